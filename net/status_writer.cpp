// SPDX-License-Identifier: Apache-2.0
#include "net/status_writer.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "net/claim_book.hpp"

namespace g3d::net {
namespace {

bool are_near(double a, double b, double share, double least) {
  return std::abs(a - b) <= std::max(least, share * std::max(std::abs(a), std::abs(b)));
}

}  // namespace

bool StatusWriter::is_due(StatusKind kind, hal::TimeNs after_ns, hal::TimeNs now_ns) {
  const Said& before = said(kind);
  return !before.was || now_ns - before.when_ns >= after_ns;
}

bool StatusWriter::publish(StatusKind kind, hal::TimeNs now_ns) {
  if (!gossip_.publish(status_key(kind), Lane::ground, next_.bytes())) {
    ++counts_.refused;
    return false;
  }
  gossip_.commit(now_ns);
  Said& now = said(kind);
  now.was = true;
  now.when_ns = now_ns;
  now.bytes = next_;
  ++counts_.words[static_cast<std::size_t>(kind)];
  counts_.bytes += next_.bytes().size();
  return true;
}

bool StatusWriter::is_urgent(const MotionWord& word) const {
  return word.is_moving != motion_.is_moving || word.has_goal != motion_.has_goal ||
         (word.has_goal && apart_m(word.goal, motion_.goal) > pace_.same_goal_m);
}

bool StatusWriter::has_moved(const MotionWord& word) const {
  const double turned_rad =
      std::remainder(word.T_world_base.heading_rad - motion_.T_world_base.heading_rad, 2.0 * std::numbers::pi);
  return apart_m(word.T_world_base, motion_.T_world_base) > pace_.still_m || std::abs(turned_rad) > pace_.still_rad;
}

void StatusWriter::say(const MotionWord& word, std::size_t robots, hal::TimeNs now_ns) {
  const hal::TimeNs moving_ns = std::max(pace_.moving_ns, static_cast<hal::TimeNs>(robots) * pace_.moving_per_robot_ns);
  const bool was = said(StatusKind::motion).was;
  const hal::TimeNs after_ns = is_urgent(word) ? pace_.urgent_ns : moving_ns;
  if (was && !is_urgent(word) && !word.is_moving && !has_moved(word)) return;
  if (!is_due(StatusKind::motion, after_ns, now_ns)) return;
  MotionWord stamped = word;
  stamped.said_ms = static_cast<std::uint32_t>(now_ns / 1'000'000);
  write_status(stamped, next_);
  if (publish(StatusKind::motion, now_ns)) motion_ = word;
}

bool StatusWriter::is_as_said(const OffersWord& word) const {
  if (word.count != offers_.count) return false;
  for (std::size_t i = 0; i < word.count; ++i) {
    const nav::Offer &now = word.offers[i], &before = offers_.offers[i];
    if (apart_m(now.goal, before.goal) > pace_.same_goal_m ||
        !are_near(now.travel_s, before.travel_s, pace_.same_share, pace_.same_s) ||
        !are_near(now.gain_cells, before.gain_cells, pace_.same_share, 1.0)) {
      return false;
    }
  }
  return true;
}

void StatusWriter::say(const OffersWord& word, hal::TimeNs now_ns) {
  if (said(StatusKind::offers).was ? is_as_said(word) : word.count == 0) return;
  if (!is_due(StatusKind::offers, pace_.offers_ns, now_ns)) return;
  write_status(word, next_);
  if (publish(StatusKind::offers, now_ns)) offers_ = word;
}

template <typename Word>
void StatusWriter::say_changed(StatusKind kind, const Word& word, hal::TimeNs after_ns, hal::TimeNs now_ns) {
  if (!is_due(kind, after_ns, now_ns)) return;
  write_status(word, next_);
  const mapper::ByteSpan now = next_.bytes(), before = said(kind).bytes.bytes();
  if (said(kind).was && std::equal(now.begin(), now.end(), before.begin(), before.end())) return;
  (void)publish(kind, now_ns);
}

void StatusWriter::say(const StateWord& word, hal::TimeNs now_ns) {
  say_changed(StatusKind::state, word, pace_.state_ns, now_ns);
}
void StatusWriter::say(const ContactWord& word, hal::TimeNs now_ns) {
  say_changed(StatusKind::contact, word, pace_.contact_ns, now_ns);
}
void StatusWriter::say(const OrdersWord& word, hal::TimeNs now_ns) {
  if (!said(StatusKind::orders).was && word.count == 0) return;
  say_changed(StatusKind::orders, word, pace_.contact_ns, now_ns);
}

}  // namespace g3d::net
