// SPDX-License-Identifier: Apache-2.0
// When a robot says what of itself: what others wait for at once, how it moves a few times a second, and nothing that
// is as it was said before. A robot that stands says nothing. One thread; allocates nothing.
#pragma once

#include <array>
#include <cstdint>

#include "hal/messages.hpp"
#include "net/gossip.hpp"
#include "net/robot_status.hpp"

namespace g3d::net {

struct StatusPace {
  hal::TimeNs urgent_ns = 100'000'000;           ///< between words about a new goal, setting out and standing still
  hal::TimeNs moving_ns = 400'000'000;           ///< between words while it moves,
  hal::TimeNs moving_per_robot_ns = 40'000'000;  ///< and not below this for each who is told
  hal::TimeNs offers_ns = 1'000'000'000;
  hal::TimeNs state_ns = 1'000'000'000;
  hal::TimeNs contact_ns = 200'000'000;
  double still_m = 0.03;  ///< by so much a pose may differ from what was said of a robot that stands,
  double still_rad = 0.05;
  double same_goal_m = 0.05;
  double same_share = 0.1;  ///< of a travel time or a gain, that need not be told
  double same_s = 1.0;
};

struct StatusCounts {
  std::array<std::uint64_t, kStatusKinds> words{};  ///< by StatusKind
  std::uint64_t bytes = 0;
  std::uint64_t refused = 0;  ///< no room in the store; tried again
};

class StatusWriter {
 public:
  /// `gossip` outlives this.
  StatusWriter(const StatusPace& pace, Gossip& gossip) : pace_(pace), gossip_(gossip) {}

  /// Each says it if it is due. `robots`: that are told.
  void say(const MotionWord& word, std::size_t robots, hal::TimeNs now_ns);
  void say(const OffersWord& word, hal::TimeNs now_ns);
  void say(const StateWord& word, hal::TimeNs now_ns);
  void say(const ContactWord& word, hal::TimeNs now_ns);
  void say(const OrdersWord& word, hal::TimeNs now_ns);
  [[nodiscard]] const StatusCounts& counts() const { return counts_; }

 private:
  struct Said {
    bool was = false;
    hal::TimeNs when_ns = 0;
    StatusBytes bytes;
  };
  [[nodiscard]] Said& said(StatusKind kind) { return said_[static_cast<std::size_t>(kind)]; }
  [[nodiscard]] bool is_due(StatusKind kind, hal::TimeNs after_ns, hal::TimeNs now_ns);
  [[nodiscard]] bool is_urgent(const MotionWord& word) const;
  [[nodiscard]] bool has_moved(const MotionWord& word) const;
  [[nodiscard]] bool is_as_said(const OffersWord& word) const;
  /// If it differs from what was said.
  template <typename Word>
  void say_changed(StatusKind kind, const Word& word, hal::TimeNs after_ns, hal::TimeNs now_ns);
  /// False if there was no room.
  bool publish(StatusKind kind, hal::TimeNs now_ns);

  StatusPace pace_;
  Gossip& gossip_;
  std::array<Said, kStatusKinds> said_{};
  MotionWord motion_;
  OffersWord offers_;
  StatusBytes next_;
  StatusCounts counts_;
};

}  // namespace g3d::net
