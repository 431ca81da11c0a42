// SPDX-License-Identifier: Apache-2.0
// The part of OutgoingStream that finds out from words, or from their absence, what has come and what is lost.
#include <algorithm>

#include "net/outgoing_stream.hpp"

namespace g3d::net {
namespace {

/// Datagrams may overtake each other by so many before the late one counts as lost.
constexpr std::int32_t kStreamReorder = 3;
constexpr hal::TimeNs kLeastPatience_ns = 100'000'000;
constexpr hal::TimeNs kMostPatience_ns = 2'000'000'000;
/// More than that is not sent again only because there was no word: it is the word that may be lost.
constexpr std::size_t kStreamSmall_bytes = 400;

/// Of sequence numbers, which may wrap around.
std::int32_t distance(std::uint32_t from, std::uint32_t to) { return static_cast<std::int32_t>(to - from); }
/// The latest number below `next` that ends in these bits.
std::uint32_t latest_before(std::uint32_t next, std::uint16_t bits) {
  return next - 1 - static_cast<std::uint16_t>(next - 1 - bits);
}

}  // namespace

void OutgoingStream::on_want(const LayerStore& store, const SeenNumbers& seen, std::uint32_t next_news,
                             std::span<const WantedLayer> wanted, hal::TimeNs now_ns) {
  const std::uint32_t last_data = latest_before(next_sequence_, seen.data);
  const std::uint32_t last_news = latest_before(next_news, seen.news);
  // Words may overtake each other: the newest counts. But who has lost its memory of us begins again with nothing.
  const bool is_older = distance(last_data_, last_data) < 0 || distance(last_news_, last_news) < 0;
  if (word_ns_ != kNoWord && is_older && now_ns - word_ns_ < kMostPatience_ns) return;
  subscription_count_ = 0;
  for (const WantedLayer& each : wanted) {
    const LayerIndex layer = store.find(each.layer);
    if (layer == kNoLayer || subscription_count_ == subscriptions_->size() || find(layer) != nullptr) continue;
    (*subscriptions_)[subscription_count_++] = {layer, each.had};
  }
  last_data_ = last_data;
  last_news_ = last_news;
  word_ns_ = now_ns;
  silences_ = 0;
  resolve(now_ns);
}

template <typename Keeps>
void OutgoingStream::keep_in_flight(Keeps&& keeps) {
  const auto begin = in_flight_.begin();
  const auto end = std::remove_if(begin, begin + static_cast<std::ptrdiff_t>(in_flight_count_),
                                  [&](const InFlight& flight) { return !keeps(flight); });
  in_flight_count_ = static_cast<std::size_t>(end - begin);
}

void OutgoingStream::resolve(hal::TimeNs now_ns) {
  keep_in_flight([&](const InFlight& flight) {
    const std::uint32_t last = flight.is_news ? last_news_ : last_data_;
    if (flight.sequence == last && now_ns > flight.sent_ns) {
      answer_time_ns_ += (now_ns - flight.sent_ns - answer_time_ns_) / 4;
    }
    const Subscription* subscription = find(flight.layer);
    if (subscription == nullptr) return false;
    if (subscription->had[static_cast<std::size_t>(flight.lane)].covers(flight.range)) return false;
    const hal::TimeNs age_ns = now_ns - flight.sent_ns;
    const std::int32_t later = distance(flight.sequence, last);
    const bool is_lost =
        later >= kStreamReorder || (later > 0 && age_ns >= kLeastPatience_ns) || age_ns > overdue_after_ns();
    if (is_lost) ++lost_segments_;
    return !is_lost;
  });
}

hal::TimeNs OutgoingStream::overdue_after_ns() const {
  hal::TimeNs patience = std::max(kLeastPatience_ns, answer_time_ns_ + answer_time_ns_ / 2);
  for (int i = 0; i < silences_ && patience < kMostPatience_ns; ++i) patience += patience / 2;
  return std::min(kMostPatience_ns, patience);
}

bool OutgoingStream::give_up_overdue(hal::TimeNs now_ns) {
  if (in_flight_count_ == 0) return false;
  const InFlight oldest = in_flight_[0];
  if (now_ns - std::max(oldest.sent_ns, probed_ns_) <= overdue_after_ns()) return false;
  probed_ns_ = now_ns;
  ++silences_;
  // It may be the answer that was lost. So one datagram goes again: the answer to it tells of all the others.
  const auto is_oldest = [&](const InFlight& f) {
    return f.sequence == oldest.sequence && f.is_news == oldest.is_news;
  };
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < in_flight_count_; ++i) bytes += is_oldest(in_flight_[i]) ? in_flight_[i].bytes : 0U;
  if (bytes > kStreamSmall_bytes) return true;
  ++lost_segments_;
  keep_in_flight([&](const InFlight& flight) { return !is_oldest(flight); });
  return false;
}

}  // namespace g3d::net
