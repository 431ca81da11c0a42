// SPDX-License-Identifier: Apache-2.0
#include "net/outgoing_stream.hpp"

#include <algorithm>

namespace g3d::net {

std::optional<VersionRange> write_segment(const LayerStore& store, LayerIndex layer, Lane lane, const VersionRange& gap,
                                          MessageWriter& message) {
  auto record = store.first_after(layer, lane, gap.after);
  if (record && record->version > gap.upto) record.reset();
  const std::size_t first_bytes = record ? record->bytes : 0;
  if (!message.begin_segment(alias_of(store.id(layer)), lane, gap.after, first_bytes)) return std::nullopt;
  VersionRange sent{gap.after, gap.after};
  while (record && record->version <= gap.upto) {
    const auto place = message.add_record(record->key, record->version, record->bytes);
    if (!place) break;
    store.read(*record, *place);
    sent.upto = record->version;
    record = store.first_after(layer, lane, sent.upto);
  }
  if (!record || record->version > gap.upto) sent.upto = gap.upto;
  message.end_segment(sent.upto);
  return sent;
}

OutgoingStream::OutgoingStream()
    : subscriptions_(std::make_unique<mapper::ReservedArray<Subscription>>(kMostWantedInMessage)) {}

const OutgoingStream::Subscription* OutgoingStream::find(LayerIndex layer) const {
  const Subscription* const begin = subscriptions_->data();
  const Subscription* const end = begin + subscription_count_;
  const Subscription* const it = std::find_if(begin, end, [&](const Subscription& s) { return s.layer == layer; });
  return it == end ? nullptr : it;
}

bool OutgoingStream::lacks(const LayerStore& store, std::size_t i) const {
  const Subscription& subscription = (*subscriptions_)[i];
  return std::any_of(kAllLanes.begin(), kAllLanes.end(), [&](Lane lane) {
    return store.had(subscription.layer, lane).highest() > subscription.had[static_cast<std::size_t>(lane)].upto();
  });
}

VersionRange OutgoingStream::next_gap(const LayerStore& store, std::size_t i, Lane lane) const {
  const Subscription& subscription = (*subscriptions_)[i];
  const VersionRanges& ours = store.had(subscription.layer, lane);
  const VersionRanges& theirs = subscription.had[static_cast<std::size_t>(lane)];
  if (ours.highest() <= theirs.upto()) return {};
  VersionRanges coming = theirs;
  for (std::size_t f = 0; f < in_flight_count_; ++f) {
    const InFlight& flight = in_flight_[f];
    if (flight.layer == subscription.layer && flight.lane == lane) (void)coming.add(flight.range);
  }
  VersionRange gap = coming.first_gap({0, ours.upto()});
  for (const VersionRange& range : ours.beyond()) {
    if (gap.after < gap.upto) break;
    gap = coming.first_gap(range);
  }
  return gap;
}

void OutgoingStream::note_news(std::uint32_t sequence, std::size_t i, Lane lane, const VersionRange& range,
                               std::size_t bytes, hal::TimeNs now_ns) {
  if (in_flight_count_ == kMostInFlight) return;
  if ((*subscriptions_)[i].had[static_cast<std::size_t>(lane)].covers(range)) return;
  note_sent(sequence, true, i, lane, range, bytes, now_ns);
}

void OutgoingStream::note_sent(std::uint32_t sequence, bool is_news, std::size_t i, Lane lane,
                               const VersionRange& range, std::size_t bytes, hal::TimeNs now_ns) {
  in_flight_[in_flight_count_++] = {sequence, is_news, wanted_layer(i), lane, static_cast<std::uint16_t>(bytes),
                                    range,    now_ns};
}

bool OutgoingStream::next(const LayerStore& store, MessageWriter& message, hal::TimeNs now_ns) {
  const bool asks = give_up_overdue(now_ns);
  const std::size_t before = in_flight_count_;
  bool has_room = true;
  bool has_begun = false;
  for (const Lane lane : kAllLanes) {
    for (std::size_t i = 0; i < subscription_count_ && has_room; ++i) {
      const std::size_t turn = (turn_ + i) % subscription_count_;
      for (;;) {
        const VersionRange gap = next_gap(store, turn, lane);
        if (gap.upto <= gap.after) break;
        if (in_flight_count_ == kMostInFlight) {
          has_room = false;
          break;
        }
        if (!has_begun) message.begin_data(static_cast<std::uint16_t>(next_sequence_));
        has_begun = true;
        const std::size_t size = message.size();
        const auto sent = write_segment(store, wanted_layer(turn), lane, gap, message);
        if (sent) note_sent(next_sequence_, false, turn, lane, *sent, message.size() - size, now_ns);
        has_room = sent && sent->upto == gap.upto;
        if (!has_room) break;
      }
    }
  }
  if (in_flight_count_ == before) {
    if (!asks) return false;
    message.begin_data(static_cast<std::uint16_t>(next_sequence_));
  }
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
