// SPDX-License-Identifier: Apache-2.0
// What one other robot wants from us, and what of it is on its way. It has told where it stands in each layer that it
// wants; everything beyond is sent, the ground lane of all layers first, each datagram once. What does not show in its
// next word though later datagrams do, or though it was sent longer ago than an answer takes, is lost and sent again.
// Without any word one small datagram is sent again, or an empty one, which asks for a word. What several want is
// better sent to all of them at once (news_stream.hpp): it then is under way here too. One thread.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "hal/messages.hpp"
#include "mapper/pool.hpp"
#include "net/layer_store.hpp"
#include "net/sync_message.hpp"

namespace g3d::net {

/// Writes a segment: records of `gap` as far as they fit. Returns what it completes; nothing if none fits.
[[nodiscard]] std::optional<VersionRange> write_segment(const LayerStore& store, LayerIndex layer, Lane lane,
                                                        const VersionRange& gap, MessageWriter& message);

class OutgoingStream {
 public:
  /// Datagrams' segments under way; more are not sent before an answer comes.
  static constexpr std::size_t kMostInFlight = 64;

  OutgoingStream();

  /// Its word: these layers, from there on, and nothing else. Layers that we do not have are passed over.
  /// `next_news`: number of the next message to all.
  void on_want(const LayerStore& store, const SeenNumbers& seen, std::uint32_t next_news,
               std::span<const WantedLayer> wanted, hal::TimeNs now_ns);
  /// Writes the next data message. False if nothing is to be sent now.
  [[nodiscard]] bool next(const LayerStore& store, MessageWriter& message, hal::TimeNs now_ns);
  /// It has started anew, or is gone.
  void clear();

  /// The layers that it wants.
  [[nodiscard]] std::size_t wanted_count() const { return subscription_count_; }
  [[nodiscard]] LayerIndex wanted_layer(std::size_t i) const { return (*subscriptions_)[i].layer; }
  /// Whether anything of it is not had yet, under way or not.
  [[nodiscard]] bool lacks(const LayerStore& store, std::size_t i) const;
  /// The first of what it wants of a lane and that is not under way; an empty range if there is nothing.
  [[nodiscard]] VersionRange next_gap(const LayerStore& store, std::size_t i, Lane lane) const;
  /// A message to all, which it is to hear, has that range, in so many bytes. Forgotten if there is no room: then it is
  /// sent again.
  void note_news(std::uint32_t sequence, std::size_t i, Lane lane, const VersionRange& range, std::size_t bytes,
                 hal::TimeNs now_ns);

  [[nodiscard]] std::size_t in_flight() const { return in_flight_count_; }
  [[nodiscard]] hal::TimeNs answer_time_ns() const { return answer_time_ns_; }
  [[nodiscard]] std::uint64_t lost_segments() const { return lost_segments_; }

 private:
  static constexpr hal::TimeNs kNoWord = -1;
  struct Subscription {
    LayerIndex layer;
    HadLanes had;
  };
  struct InFlight {
    std::uint32_t sequence = 0;
    bool is_news = false;
    LayerIndex layer = kNoLayer;
    Lane lane = Lane::rest;
    std::uint16_t bytes = 0;
    VersionRange range;
    hal::TimeNs sent_ns = 0;
  };

  [[nodiscard]] const Subscription* find(LayerIndex layer) const;
  void resolve(hal::TimeNs now_ns);
  void note_sent(std::uint32_t sequence, bool is_news, std::size_t i, Lane lane, const VersionRange& range,
                 std::size_t bytes, hal::TimeNs now_ns);
  /// True if a word is to be asked for.
  [[nodiscard]] bool give_up_overdue(hal::TimeNs now_ns);
  template <typename Keeps>
  void keep_in_flight(Keeps&& keeps);
  [[nodiscard]] hal::TimeNs overdue_after_ns() const;

  /// Most robots want few layers of most others: pages that are not touched cost nothing.
  std::unique_ptr<mapper::ReservedArray<Subscription>> subscriptions_;
  std::size_t subscription_count_ = 0;
  std::size_t turn_ = 0;  ///< which subscription comes first
  std::array<InFlight, kMostInFlight> in_flight_{};
  std::size_t in_flight_count_ = 0;
  std::uint32_t next_sequence_ = 1;
  std::uint32_t last_data_ = 0;  ///< the highest of our numbers that it has seen
  std::uint32_t last_news_ = 0;
  hal::TimeNs word_ns_ = kNoWord;
  hal::TimeNs answer_time_ns_ = 100'000'000;  ///< from datagram to the word about it, averaged
  int silences_ = 0;                          ///< in a row; each makes the patience half as long again
  hal::TimeNs probed_ns_ = 0;                 ///< when something was last sent again unasked
  std::uint64_t lost_segments_ = 0;
};

}  // namespace g3d::net
