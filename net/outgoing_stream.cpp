// SPDX-License-Identifier: Apache-2.0
#include "net/outgoing_stream.hpp"

#include <algorithm>

namespace g3d::net {
namespace {

/// Datagrams may overtake each other by so many before the late one counts as lost.
constexpr std::int32_t kStreamReorder = 3;
constexpr hal::TimeNs kLeastPatience_ns = 100'000'000;
constexpr hal::TimeNs kMostPatience_ns = 2'000'000'000;

/// Of sequence numbers, which may wrap around.
std::int32_t distance(std::uint32_t from, std::uint32_t to) { return static_cast<std::int32_t>(to - from); }

}  // namespace

const OutgoingStream::Subscription* OutgoingStream::find(LayerIndex layer) const {
  const auto end = subscriptions_.begin() + static_cast<std::ptrdiff_t>(subscription_count_);
  const auto it = std::find_if(subscriptions_.begin(), end, [&](const Subscription& s) { return s.layer == layer; });
  return it == end ? nullptr : &*it;
}

void OutgoingStream::on_want(const LayerStore& store, std::uint32_t last_seen, std::span<const LayerPosition> positions,
                             hal::TimeNs now_ns) {
  // Words may overtake each other: the newest counts. But who has lost its memory of us begins again with nothing.
  if (word_ns_ != kNoWord && distance(last_seen_, last_seen) < 0 && now_ns - word_ns_ < kMostPatience_ns) return;
  subscription_count_ = 0;
  for (const LayerPosition& position : positions) {
    const LayerIndex layer = store.find(position.id);
    if (layer == kNoLayer || subscription_count_ == subscriptions_.size()) continue;
    subscriptions_[subscription_count_++] = {layer, position.had};
  }
  last_seen_ = last_seen;
  word_ns_ = now_ns;
  silences_ = 0;
  resolve(last_seen, now_ns);
}

template <typename Keeps>
void OutgoingStream::keep_in_flight(Keeps&& keeps) {
  const auto begin = in_flight_.begin();
  const auto end = std::remove_if(begin, begin + static_cast<std::ptrdiff_t>(in_flight_count_),
                                  [&](const InFlight& flight) { return !keeps(flight); });
  in_flight_count_ = static_cast<std::size_t>(end - begin);
}

void OutgoingStream::resolve(std::uint32_t last_seen, hal::TimeNs now_ns) {
  keep_in_flight([&](const InFlight& flight) {
    if (flight.sequence == last_seen && now_ns > flight.sent_ns) {
      answer_time_ns_ += (now_ns - flight.sent_ns - answer_time_ns_) / 4;
    }
    const Subscription* subscription = find(flight.layer);
    if (subscription == nullptr) return false;
    if (subscription->had[static_cast<std::size_t>(flight.lane)].covers(flight.range)) return false;
    const bool is_lost = distance(flight.sequence, last_seen) >= kStreamReorder;
    if (is_lost) ++lost_segments_;
    return !is_lost;
  });
}

hal::TimeNs OutgoingStream::overdue_after_ns() const {
  const hal::TimeNs patience = std::max(kLeastPatience_ns, answer_time_ns_ + answer_time_ns_ / 2);
  return std::min(kMostPatience_ns, patience << std::min(silences_, 5));
}

void OutgoingStream::give_up_overdue(hal::TimeNs now_ns) {
  if (in_flight_count_ == 0) return;
  const InFlight& oldest = in_flight_[0];
  if (now_ns - std::max(oldest.sent_ns, probed_ns_) <= overdue_after_ns()) return;
  // It may be the answer that was lost. So one datagram goes again: the answer to it tells of all the others.
  const std::uint32_t sequence = oldest.sequence;
  keep_in_flight([&](const InFlight& flight) { return flight.sequence != sequence; });
  probed_ns_ = now_ns;
  ++lost_segments_;
  ++silences_;
}

VersionRange OutgoingStream::next_gap(const LayerStore& store, const Subscription& subscription, Lane lane) const {
  const VersionRanges& ours = store.had(subscription.layer, lane);
  VersionRanges coming = subscription.had[static_cast<std::size_t>(lane)];
  if (ours.highest() <= coming.upto()) return {};
  for (std::size_t i = 0; i < in_flight_count_; ++i) {
    const InFlight& flight = in_flight_[i];
    if (flight.layer == subscription.layer && flight.lane == lane) (void)coming.add(flight.range);
  }
  VersionRange gap = coming.first_gap({0, ours.upto()});
  for (const VersionRange& range : ours.beyond()) {
    if (gap.after < gap.upto) break;
    gap = coming.first_gap(range);
  }
  return gap;
}

bool OutgoingStream::add_segment(const LayerStore& store, const Subscription& subscription, Lane lane, VersionRange gap,
                                 MessageWriter& message, hal::TimeNs now_ns) {
  auto record = store.first_after(subscription.layer, lane, gap.after);
  if (record && record->version > gap.upto) record.reset();
  if (!message.begin_segment(store.id(subscription.layer), lane, gap.after, record ? record->bytes : 0)) return false;
  VersionRange sent{gap.after, gap.upto};
  while (record && record->version <= gap.upto) {
    const auto place = message.add_record(record->key, record->version, record->bytes);
    if (!place) break;
    store.read(*record, *place);
    sent.upto = record->version;
    record = store.first_after(subscription.layer, lane, sent.upto);
  }
  if (!record || record->version > gap.upto) sent.upto = gap.upto;
  message.end_segment(sent.upto);
  in_flight_[in_flight_count_++] = {next_sequence_, subscription.layer, lane, sent, now_ns};
  return sent.upto == gap.upto;
}

bool OutgoingStream::next(const LayerStore& store, MessageWriter& message, hal::TimeNs now_ns) {
  give_up_overdue(now_ns);
  const std::size_t before = in_flight_count_;
  bool has_room = true;
  bool has_begun = false;
  for (const Lane lane : kAllLanes) {
    for (std::size_t i = 0; i < subscription_count_ && has_room; ++i) {
      const Subscription& subscription = subscriptions_[(turn_ + i) % subscription_count_];
      for (;;) {
        const VersionRange gap = next_gap(store, subscription, lane);
        if (gap.upto <= gap.after) break;
        if (in_flight_count_ == kMostInFlight) {
          has_room = false;
          break;
        }
        if (!has_begun) message.begin_data(next_sequence_);
        has_begun = true;
        has_room = add_segment(store, subscription, lane, gap, message, now_ns);
        if (!has_room) break;
      }
    }
  }
  if (in_flight_count_ == before) return false;
  if (subscription_count_ > 0) turn_ = (turn_ + 1) % subscription_count_;
  ++next_sequence_;
  return true;
}

void OutgoingStream::clear() {
  subscription_count_ = 0;
  in_flight_count_ = 0;
  silences_ = 0;
  word_ns_ = kNoWord;
  probed_ns_ = 0;
}

}  // namespace g3d::net
