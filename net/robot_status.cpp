// SPDX-License-Identifier: Apache-2.0
#include "net/robot_status.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "net/wire_parts.hpp"

namespace g3d::net {
namespace {

constexpr std::uint8_t kMovesFlag = 1, kHasGoalFlag = 2;
constexpr double kMostStatus_cm = 100.0 * kMostCoordinate_m;
/// Nobody plans further ahead than some hours.
constexpr std::uint64_t kMostStatus_ds = 1'000'000;
constexpr std::uint64_t kMostGain_cells = 16'000'000;  // a float has them all
constexpr std::uint64_t kMostRadius_cm = 1'000;
constexpr std::uint64_t kMostTerm = std::uint64_t{1} << 48;
constexpr double kTurn_rad = 2.0 * std::numbers::pi;

/// Rounded; what is no number is 0.
std::int64_t whole(double value, double most) {
  if (!(std::abs(value) <= most)) value = std::isnan(value) ? 0.0 : std::copysign(most, value);
  return std::llround(value);
}
std::int64_t cm_of(double metres) { return whole(100.0 * metres, kMostStatus_cm); }
std::uint64_t count_of(double value, std::uint64_t most) {
  return static_cast<std::uint64_t>(whole(std::max(0.0, value), static_cast<double>(most)));
}
std::uint64_t packed(std::int64_t value) { return zigzag(static_cast<std::uint64_t>(value)); }

std::uint16_t heading_of(double heading_rad) {
  return static_cast<std::uint16_t>(whole(std::remainder(heading_rad, kTurn_rad) * 65536.0 / kTurn_rad, 65536.0));
}
double rad_of(std::uint16_t heading) {
  // (-pi, pi]
  const int turns = heading > 32768 ? int{heading} - 65536 : int{heading};
  return turns * kTurn_rad / 65536.0;
}

bool take_signed(mapper::ByteReader& in, std::int64_t& value) {
  std::uint64_t raw = 0;
  if (!in.take_varint(raw)) return false;
  value = static_cast<std::int64_t>(from_zigzag(raw));
  return true;
}
bool is_inside(std::int64_t cm) {
  return cm >= -static_cast<std::int64_t>(kMostStatus_cm) && cm <= static_cast<std::int64_t>(kMostStatus_cm);
}

StatusFault take_place(mapper::ByteReader& in, hal::PlanarPose& place) {
  std::int64_t x_cm = 0, y_cm = 0;
  std::uint16_t heading = 0;
  if (!take_signed(in, x_cm) || !take_signed(in, y_cm) || !in.take(heading)) return StatusFault::truncated;
  if (!is_inside(x_cm) || !is_inside(y_cm)) return StatusFault::bad_place;
  place = {static_cast<double>(x_cm) / 100.0, static_cast<double>(y_cm) / 100.0, rad_of(heading)};
  return StatusFault::none;
}

StatusFault take_count(mapper::ByteReader& in, std::size_t most, std::size_t& count) {
  std::uint8_t taken = 0;
  if (!in.take(taken)) return StatusFault::truncated;
  if (taken > most) return StatusFault::bad_count;
  count = taken;
  return StatusFault::none;
}

StatusFault take_number(mapper::ByteReader& in, std::uint64_t most, std::uint64_t& value) {
  if (!in.take_varint(value)) return StatusFault::truncated;
  return value > most ? StatusFault::bad_number : StatusFault::none;
}

StatusFault take_way(mapper::ByteReader& in, MotionWord& word) {
  if (const StatusFault fault = take_count(in, word.way.size(), word.way_count); fault != StatusFault::none) {
    return fault;
  }
  std::int64_t x_cm = cm_of(word.T_world_base.x_m), y_cm = cm_of(word.T_world_base.y_m);
  std::uint64_t after_ds = 0;
  for (std::size_t i = 0; i < word.way_count; ++i) {
    std::int64_t dx_cm = 0, dy_cm = 0;
    std::uint64_t later_ds = 0;
    if (!take_signed(in, dx_cm) || !take_signed(in, dy_cm) || !in.take_varint(later_ds)) return StatusFault::truncated;
    // The sum of two numbers within twice the world is one.
    if (!is_inside(dx_cm / 2) || !is_inside(dy_cm / 2)) return StatusFault::bad_place;
    if (later_ds > kMostStatus_ds) return StatusFault::bad_number;
    x_cm += dx_cm;
    y_cm += dy_cm;
    after_ds += later_ds;
    if (!is_inside(x_cm) || !is_inside(y_cm)) return StatusFault::bad_place;
    if (after_ds > kMostStatus_ds) return StatusFault::bad_number;
    word.way[i] = {static_cast<float>(x_cm) / 100.0F, static_cast<float>(y_cm) / 100.0F,
                   static_cast<float>(after_ds) / 10.0F};
  }
  return StatusFault::none;
}

StatusFault take_all(mapper::ByteReader& in, MotionWord& word) {
  std::uint8_t flags = 0;
  if (!in.take(flags)) return StatusFault::truncated;
  if ((flags & ~(kMovesFlag | kHasGoalFlag)) != 0) return StatusFault::bad_flags;
  if (!in.take(word.said_ms)) return StatusFault::truncated;
  word.is_moving = (flags & kMovesFlag) != 0;
  word.has_goal = (flags & kHasGoalFlag) != 0;
  StatusFault fault = take_place(in, word.T_world_base);
  if (fault == StatusFault::none && word.has_goal) fault = take_place(in, word.goal);
  return fault == StatusFault::none ? take_way(in, word) : fault;
}

StatusFault take_all(mapper::ByteReader& in, OffersWord& word) {
  StatusFault fault = take_count(in, word.offers.size(), word.count);
  for (std::size_t i = 0; fault == StatusFault::none && i < word.count; ++i) {
    std::uint64_t travel_ds = 0, gain_cells = 0;
    fault = take_place(in, word.offers[i].goal);
    if (fault == StatusFault::none) fault = take_number(in, kMostStatus_ds, travel_ds);
    if (fault == StatusFault::none) fault = take_number(in, kMostGain_cells, gain_cells);
    word.offers[i].travel_s = static_cast<float>(travel_ds) / 10.0F;
    word.offers[i].gain_cells = static_cast<float>(gain_cells);
  }
  return fault;
}

StatusFault take_all(mapper::ByteReader& in, StateWord& word) {
  std::uint8_t mission = 0;
  std::uint64_t radius_cm = 0;
  if (!in.take(mission) || !in.take(word.battery_percent)) return StatusFault::truncated;
  if (mission > static_cast<std::uint8_t>(nav::MissionState::needs_help) || word.battery_percent > 100) {
    return StatusFault::bad_number;
  }
  if (const StatusFault fault = take_number(in, kMostRadius_cm, radius_cm); fault != StatusFault::none) return fault;
  if (!in.take(word.map_incarnation)) return StatusFault::truncated;
  word.mission = static_cast<nav::MissionState>(mission);
  word.radius_m = static_cast<float>(radius_cm) / 100.0F;
  return StatusFault::none;
}

StatusFault take_all(mapper::ByteReader& in, ContactWord& word) {
  if (!in.take(word.office.leader)) return StatusFault::truncated;
  StatusFault fault = take_number(in, kMostTerm, word.office.term);
  // Who has no leader has no term either.
  if (fault == StatusFault::none && (word.office.leader == 0) != (word.office.term == 0)) {
    fault = StatusFault::bad_number;
  }
  if (fault == StatusFault::none) fault = take_count(in, word.heard.size(), word.heard_count);
  for (std::size_t i = 0; fault == StatusFault::none && i < word.heard_count; ++i) {
    if (!in.take(word.heard[i])) return StatusFault::truncated;
    if (word.heard[i] <= (i == 0 ? 0 : word.heard[i - 1])) fault = StatusFault::bad_order;
  }
  return fault;
}

StatusFault take_all(mapper::ByteReader& in, OrdersWord& word) {
  StatusFault fault = take_number(in, kMostTerm, word.term);
  if (fault == StatusFault::none) fault = take_count(in, word.orders.size(), word.count);
  for (std::size_t i = 0; fault == StatusFault::none && i < word.count; ++i) {
    if (!in.take(word.orders[i].robot)) return StatusFault::truncated;
    if (word.orders[i].robot <= (i == 0 ? 0 : word.orders[i - 1].robot)) return StatusFault::bad_order;
    fault = take_place(in, word.orders[i].goal);
  }
  return fault;
}

template <typename Word>
StatusFault read_whole(mapper::ByteSpan payload, Word& word) {
  mapper::ByteReader in(payload);
  Word read;
  const StatusFault fault = take_all(in, read);
  if (fault != StatusFault::none) return fault;
  if (in.left() > 0) return StatusFault::left_over;
  word = read;
  return StatusFault::none;
}

}  // namespace

bool ContactWord::hears(RobotId robot) const {
  return std::binary_search(heard.begin(), heard.begin() + static_cast<std::ptrdiff_t>(heard_count), robot);
}

void StatusBytes::put_u16(std::uint16_t value) {
  std::memcpy(bytes_.data() + size_, &value, sizeof value);
  size_ += sizeof value;
}
void StatusBytes::put_u32(std::uint32_t value) {
  std::memcpy(bytes_.data() + size_, &value, sizeof value);
  size_ += sizeof value;
}
void StatusBytes::put_u64(std::uint64_t value) {
  std::memcpy(bytes_.data() + size_, &value, sizeof value);
  size_ += sizeof value;
}
void StatusBytes::put_varint(std::uint64_t value) {
  for (; value >= 0x80U; value >>= 7) put_u8(static_cast<std::uint8_t>(value | 0x80U));
  put_u8(static_cast<std::uint8_t>(value));
}
void StatusBytes::put_place(const hal::PlanarPose& place) {
  put_varint(packed(cm_of(place.x_m)));
  put_varint(packed(cm_of(place.y_m)));
  put_u16(heading_of(place.heading_rad));
}

void write_status(const MotionWord& word, StatusBytes& out) {
  out.clear();
  out.put_u8(static_cast<std::uint8_t>((word.is_moving ? kMovesFlag : 0) | (word.has_goal ? kHasGoalFlag : 0)));
  out.put_u32(word.said_ms);
  out.put_place(word.T_world_base);
  if (word.has_goal) out.put_place(word.goal);
  const std::size_t count = std::min(word.way_count, word.way.size());
  out.put_u8(static_cast<std::uint8_t>(count));
  std::int64_t x_cm = cm_of(word.T_world_base.x_m), y_cm = cm_of(word.T_world_base.y_m);
  std::uint64_t after_ds = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const nav::WayPoint& point = word.way[i];
    const std::int64_t to_x_cm = cm_of(point.x_m), to_y_cm = cm_of(point.y_m);
    const std::uint64_t then_ds = std::max(after_ds, count_of(10.0 * point.after_s, kMostStatus_ds));
    out.put_varint(packed(to_x_cm - x_cm));
    out.put_varint(packed(to_y_cm - y_cm));
    out.put_varint(then_ds - after_ds);
    x_cm = to_x_cm;
    y_cm = to_y_cm;
    after_ds = then_ds;
  }
}

void write_status(const OffersWord& word, StatusBytes& out) {
  out.clear();
  const std::size_t count = std::min(word.count, word.offers.size());
  out.put_u8(static_cast<std::uint8_t>(count));
  for (std::size_t i = 0; i < count; ++i) {
    out.put_place(word.offers[i].goal);
    out.put_varint(count_of(10.0 * word.offers[i].travel_s, kMostStatus_ds));
    out.put_varint(count_of(word.offers[i].gain_cells, kMostGain_cells));
  }
}

void write_status(const StateWord& word, StatusBytes& out) {
  out.clear();
  out.put_u8(static_cast<std::uint8_t>(word.mission));
  out.put_u8(std::min<std::uint8_t>(word.battery_percent, 100));
  out.put_varint(count_of(100.0 * word.radius_m, kMostRadius_cm));
  out.put_u32(word.map_incarnation);
}

void write_status(const ContactWord& word, StatusBytes& out) {
  out.clear();
  out.put_u64(word.office.leader);
  out.put_varint(word.office.term);
  const std::size_t count = std::min(word.heard_count, word.heard.size());
  out.put_u8(static_cast<std::uint8_t>(count));
  for (std::size_t i = 0; i < count; ++i) out.put_u64(word.heard[i]);
}

void write_status(const OrdersWord& word, StatusBytes& out) {
  out.clear();
  out.put_varint(word.term);
  const std::size_t count = std::min(word.count, word.orders.size());
  out.put_u8(static_cast<std::uint8_t>(count));
  for (std::size_t i = 0; i < count; ++i) {
    out.put_u64(word.orders[i].robot);
    out.put_place(word.orders[i].goal);
  }
}

StatusFault read_status(mapper::ByteSpan payload, MotionWord& word) { return read_whole(payload, word); }
StatusFault read_status(mapper::ByteSpan payload, OffersWord& word) { return read_whole(payload, word); }
StatusFault read_status(mapper::ByteSpan payload, StateWord& word) { return read_whole(payload, word); }
StatusFault read_status(mapper::ByteSpan payload, ContactWord& word) { return read_whole(payload, word); }
StatusFault read_status(mapper::ByteSpan payload, OrdersWord& word) { return read_whole(payload, word); }

}  // namespace g3d::net
