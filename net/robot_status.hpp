// SPDX-License-Identifier: Apache-2.0
// What a robot says of itself beside its map, as records of its own layer that travel as all others do: where it is and
// goes, where it could go, how it is, whom it hears, and, if it leads, who is to go where. One record each, so that
// what stands is not said again. Places are rounded to a centimetre, headings to 2 pi / 65536, times to a tenth of a
// second.
//
//   motion   u8 flags (1 moves, 2 has a goal), u32 said at, pose, [goal], u8 count, way points
//   offers   u8 count, per offer: place, travel time in 0.1 s, gain in cells
//   state    u8 mission state, u8 battery in percent, radius in cm, u32 incarnation of its map
//   contact  u64 leader and its term, or 0 and 0; u8 count, u64 of each robot that it hears, ascending
//   orders   term; u8 count, per order: u64 robot, ascending, and place
//
//   pose, place: x and y in cm as zigzag, u16 heading    way point: x, y as differences to the one before, and so time
//   Numbers are LEB128 varints unless said otherwise.
//
// Readers take a payload as a whole or not at all. One thread; nothing allocates.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "hal/twist.hpp"
#include "mapper/files/bytes.hpp"
#include "nav/mission.hpp"
#include "nav/teammates.hpp"
#include "net/layer_id.hpp"
#include "net/record_key.hpp"

namespace g3d::net {

enum class StatusKind : std::uint8_t { motion, offers, state, contact, orders };
inline constexpr int kStatusKinds = 5;
[[nodiscard]] constexpr RecordKey status_key(StatusKind kind) {
  return status_record(static_cast<std::uint32_t>(kind));
}

inline constexpr std::size_t kMostHeard = 96;
inline constexpr std::size_t kMostOrders = 48;  ///< that fit into a payload
inline constexpr double kMostCoordinate_m = 100'000.0;

/// As nav::TeamWord has it, but for the offers.
struct MotionWord {
  std::uint32_t said_ms = 0;  ///< by the robot's own clock, modulo 2^32
  hal::PlanarPose T_world_base;
  bool is_moving = false;
  bool has_goal = false;
  hal::PlanarPose goal;
  std::array<nav::WayPoint, nav::kMostWayPoints> way{};
  std::size_t way_count = 0;
};
struct OffersWord {
  std::array<nav::Offer, nav::kMostOffers> offers{};
  std::size_t count = 0;
};
struct StateWord {
  nav::MissionState mission = nav::MissionState::starting;
  std::uint8_t battery_percent = 0;
  float radius_m = 0.0F;
  std::uint32_t map_incarnation = 0;
};
/// Whose word counts as the leader's, and in which of all terms of office; robot 0: nobody's.
struct Office {
  RobotId leader = 0;
  std::uint64_t term = 0;
  bool operator==(const Office&) const = default;
};
struct ContactWord {
  Office office;
  std::array<RobotId, kMostHeard> heard{};
  std::size_t heard_count = 0;
  [[nodiscard]] std::span<const RobotId> all_heard() const { return {heard.data(), heard_count}; }
  [[nodiscard]] bool hears(RobotId robot) const;
};
struct Order {
  RobotId robot = 0;
  hal::PlanarPose goal;
};
struct OrdersWord {
  std::uint64_t term = 0;
  std::array<Order, kMostOrders> orders{};
  std::size_t count = 0;
};

enum class StatusFault : std::uint8_t {
  none,
  truncated,
  left_over,
  bad_flags,
  bad_place,   ///< outside the world, or a way point before the one before
  bad_count,   ///< more than there may be
  bad_number,  ///< out of its range
  bad_order,   ///< robots that do not ascend
};
inline constexpr int kStatusFaults = 8;

/// A payload with memory of its own.
class StatusBytes {
 public:
  [[nodiscard]] mapper::ByteSpan bytes() const { return {bytes_.data(), size_}; }
  void clear() { size_ = 0; }
  void put_u8(std::uint8_t value) { bytes_[size_++] = value; }
  void put_u16(std::uint16_t value);
  void put_u32(std::uint32_t value);
  void put_u64(std::uint64_t value);
  void put_varint(std::uint64_t value);
  void put_place(const hal::PlanarPose& place);

 private:
  std::array<std::uint8_t, 1024> bytes_{};
  std::size_t size_ = 0;
};

// What is out of range is cut to it; of lists, what is too much is left out.
void write_status(const MotionWord& word, StatusBytes& out);
void write_status(const OffersWord& word, StatusBytes& out);
void write_status(const StateWord& word, StatusBytes& out);
void write_status(const ContactWord& word, StatusBytes& out);
void write_status(const OrdersWord& word, StatusBytes& out);

// With a fault `word` is as before.
[[nodiscard]] StatusFault read_status(mapper::ByteSpan payload, MotionWord& word);
[[nodiscard]] StatusFault read_status(mapper::ByteSpan payload, OffersWord& word);
[[nodiscard]] StatusFault read_status(mapper::ByteSpan payload, StateWord& word);
[[nodiscard]] StatusFault read_status(mapper::ByteSpan payload, ContactWord& word);
[[nodiscard]] StatusFault read_status(mapper::ByteSpan payload, OrdersWord& word);

}  // namespace g3d::net
