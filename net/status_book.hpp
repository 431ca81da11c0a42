// SPDX-License-Identifier: Apache-2.0
// What other robots last said of themselves, read out of the layers that came. Of a robot that has begun a new layer
// the words in older ones count no more. One thread; allocates at construction.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/messages.hpp"
#include "net/layer_store.hpp"
#include "net/robot_status.hpp"
#include "net/word_age.hpp"

namespace g3d::net {

struct RobotWords {
  LayerId layer;
  std::array<Version, kStatusKinds> versions{};  ///< that were looked at
  std::array<bool, kStatusKinds> is_said{};
  MotionWord motion;
  hal::TimeNs moved_ns = 0;  ///< when `motion` was so, by our clock
  OffersWord offers;
  StateWord state;
  ContactWord contact;
  OrdersWord orders;
  WordAge age;
  [[nodiscard]] bool has(StatusKind kind) const { return is_said[static_cast<std::size_t>(kind)]; }
};

struct BookCounts {
  std::uint64_t words = 0;
  std::uint64_t left_out_robots = 0;                  ///< more than there is room for, counted at every look
  std::array<std::uint64_t, kStatusFaults> faults{};  ///< by StatusFault
};

class StatusBook {
 public:
  StatusBook(RobotId self, std::size_t most_robots);

  /// Reads what is new.
  void update(const LayerStore& store, hal::TimeNs now_ns);
  /// In the order in which they were first heard of.
  [[nodiscard]] std::span<const RobotWords> all() const { return robots_; }
  [[nodiscard]] const RobotWords* find(RobotId robot) const;
  [[nodiscard]] const BookCounts& counts() const { return counts_; }

 private:
  [[nodiscard]] RobotWords* entry_of(const LayerId& layer);
  void read(const LayerStore& store, LayerIndex layer, StatusKind kind, RobotWords& words, hal::TimeNs now_ns);
  /// What cannot be read leaves the word as it was.
  [[nodiscard]] StatusFault take(StatusKind kind, mapper::ByteSpan payload, RobotWords& words, hal::TimeNs now_ns);

  RobotId self_;
  std::vector<RobotWords> robots_;  ///< reserved
  std::vector<std::uint8_t> payload_;
  BookCounts counts_;
};

}  // namespace g3d::net
