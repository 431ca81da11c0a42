// SPDX-License-Identifier: Apache-2.0
// The part of Gossip that tells others what it wants from them, and what of theirs has come.
#include <algorithm>
#include <utility>

#include "net/gossip.hpp"

namespace g3d::net {
namespace {

constexpr hal::TimeNs kGossipRetry_ns = 250'000'000;

}  // namespace

bool Gossip::lacks_from(const Peer& peer) const {
  for (LayerIndex layer = 0; layer < store_.layer_count(); ++layer) {
    if (!own_.is_ours_alone(layer) && sources_.source(layer) == peer.robot &&
        LayerSources::has_more(store_, peer, layer)) {
      return true;
    }
  }
  return false;
}

void Gossip::note_answer_time() {
  const auto alive = static_cast<hal::TimeNs>(
      std::count_if(members_.all().begin(), members_.all().end(), [](const Peer& peer) { return peer.is_alive(); }));
  answer_after_ns_ =
      options_.answer_after_ns + options_.answer_after_ns * alive / static_cast<hal::TimeNs>(options_.answer_crowd);
}

bool Gossip::want_is_due(const Peer& peer, hal::TimeNs now_ns) const {
  if (!peer.is_alive()) return false;
  if (peer.owes_want || peer.unanswered >= options_.answer_every) return true;
  if (peer.unanswered > 0) return now_ns - peer.first_unanswered_ns >= answer_after_ns_;
  // What was asked for may have been lost, or the answer to what came.
  const hal::TimeNs patience = kGossipRetry_ns << std::min(peer.silent_wants, 3);
  return now_ns - std::max(peer.want_ns, peer.data_ns) >= patience && lacks_from(peer);
}

void Gossip::send_wants(hal::TimeNs now_ns) {
  Peer* first = nullptr;
  for (Peer& peer : members_.all()) {
    if (!want_is_due(peer, now_ns)) continue;
    if (first != nullptr) return send_words(now_ns);
    first = &peer;
  }
  if (first != nullptr) send_want(*first, now_ns);
}

void Gossip::note_word(Peer& peer, hal::TimeNs now_ns) {
  if (!peer.owes_want && peer.unanswered == 0) ++peer.silent_wants;
  peer.owes_want = false;
  peer.unanswered = 0;
  peer.want_ns = now_ns;
}

bool Gossip::add_wanted_from(Peer& peer) {
  // More layers than fit are asked for in turns.
  const std::uint32_t count = store_.layer_count();
  WantedLayer wanted;
  for (std::uint32_t i = 0; i < count; ++i) {
    const LayerIndex layer = (peer.want_turn + i) % count;
    if (own_.is_ours_alone(layer) || sources_.source(layer) != peer.robot || store_.is_unclaimed(layer) ||
        store_.is_refused(layer)) {
      continue;
    }
    wanted.layer = alias_of(store_.id(layer));
    for (const Lane lane : kAllLanes) wanted.had[static_cast<std::size_t>(lane)] = store_.had(layer, lane);
    if (message_.add_wanted(wanted)) continue;
    peer.want_turn = layer;
    return false;
  }
  return true;
}

void Gossip::send_want(Peer& peer, hal::TimeNs now_ns) {
  note_word(peer, now_ns);
  message_.begin_want(peer.seen);
  (void)add_wanted_from(peer);
  send(peer.address, MessageKind::want, message_.bytes());
}

void Gossip::send_words(hal::TimeNs now_ns) {
  bool is_begun = false;
  const auto send_begun = [&] {
    if (std::exchange(is_begun, false)) send(kEverybody, MessageKind::wants, message_.bytes());
  };
  for (Peer& peer : members_.all()) {
    // Who has sent anything since our last word need not wait until it is due: there is one message anyway.
    if (!want_is_due(peer, now_ns) && (!peer.is_alive() || peer.unanswered == 0)) continue;
    const RobotAlias robot = alias_of(peer.robot);
    const std::size_t size_before = is_begun ? message_.size() : 0;
    if (!is_begun) message_.begin_wants();
    bool fits = message_.begin_part(robot, peer.seen) && add_wanted_from(peer);
    if (!fits && is_begun) {
      message_.cut(size_before);
      send_begun();
      message_.begin_wants();
      (void)message_.begin_part(robot, peer.seen);
      (void)add_wanted_from(peer);
    }
    is_begun = true;
    note_word(peer, now_ns);
  }
  send_begun();
}

}  // namespace g3d::net
