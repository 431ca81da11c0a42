// SPDX-License-Identifier: Apache-2.0
// What one other robot wants from us, and what of it is on its way. It has told where it stands in each layer that it
// wants; everything beyond is sent, the ground lane of all layers first, each datagram once. What does not show in its
// next word though later datagrams do, or not for longer than an answer takes, is lost and sent again. One thread.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "hal/messages.hpp"
#include "net/layer_store.hpp"
#include "net/sync_message.hpp"

namespace g3d::net {

class OutgoingStream {
 public:
  /// Datagrams' segments under way; more are not sent before an answer comes.
  static constexpr std::size_t kMostInFlight = 64;

  /// Its word: these layers, from there on, and nothing else. Layers that we do not have are passed over.
  void on_want(const LayerStore& store, std::uint32_t last_seen, std::span<const LayerPosition> positions,
               hal::TimeNs now_ns);
  /// Writes the next data message. False if nothing is to be sent now.
  [[nodiscard]] bool next(const LayerStore& store, MessageWriter& message, hal::TimeNs now_ns);
  /// It has started anew, or is gone.
  void clear();

  [[nodiscard]] std::size_t in_flight() const { return in_flight_count_; }
  [[nodiscard]] hal::TimeNs answer_time_ns() const { return answer_time_ns_; }
  [[nodiscard]] std::uint64_t lost_segments() const { return lost_segments_; }

 private:
  static constexpr hal::TimeNs kNoWord = -1;
  struct Subscription {
    LayerIndex layer = kNoLayer;
    std::array<VersionRanges, kLanes> had{};
  };
  struct InFlight {
    std::uint32_t sequence = 0;
    LayerIndex layer = kNoLayer;
    Lane lane = Lane::rest;
    VersionRange range;
    hal::TimeNs sent_ns = 0;
  };

  [[nodiscard]] const Subscription* find(LayerIndex layer) const;
  void resolve(std::uint32_t last_seen, hal::TimeNs now_ns);
  void give_up_overdue(hal::TimeNs now_ns);
  template <typename Keeps>
  void keep_in_flight(Keeps&& keeps);
  [[nodiscard]] VersionRange next_gap(const LayerStore& store, const Subscription& subscription, Lane lane) const;
  /// False if it does not fit.
  bool add_segment(const LayerStore& store, const Subscription& subscription, Lane lane, VersionRange gap,
                   MessageWriter& message, hal::TimeNs now_ns);
  [[nodiscard]] hal::TimeNs overdue_after_ns() const;

  std::array<Subscription, kMostPositionsInMessage> subscriptions_{};
  std::size_t subscription_count_ = 0;
  std::size_t turn_ = 0;  ///< which subscription comes first
  std::array<InFlight, kMostInFlight> in_flight_{};
  std::size_t in_flight_count_ = 0;
  std::uint32_t next_sequence_ = 1;
  std::uint32_t last_seen_ = 0;
  hal::TimeNs word_ns_ = kNoWord;
  hal::TimeNs answer_time_ns_ = 100'000'000;  ///< from datagram to the word about it, averaged
  int silences_ = 0;                          ///< in a row; each doubles the patience
  hal::TimeNs probed_ns_ = 0;                 ///< when something was last sent again unasked
  std::uint64_t lost_segments_ = 0;
};

}  // namespace g3d::net
