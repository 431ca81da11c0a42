// SPDX-License-Identifier: Apache-2.0
// What robots say of themselves, from hostile hands: any bytes, as each of the kinds. What is taken is within its
// bounds, and written again reads the same.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "net/robot_status.hpp"
#include "net/wire_parts.hpp"

namespace {

using namespace g3d::net;
using g3d::hal::PlanarPose;
using g3d::mapper::ByteSpan;

void check(bool holds) {
  if (!holds) std::abort();
}

void check_place(const PlanarPose& place) {
  check(std::abs(place.x_m) <= kMostCoordinate_m && std::abs(place.y_m) <= kMostCoordinate_m);
  check(std::abs(place.heading_rad) < 3.1416);
}

void check_bounds(const MotionWord& word) {
  check_place(word.T_world_base);
  check_place(word.goal);
  check(word.way_count <= word.way.size());
  for (std::size_t i = 1; i < word.way_count; ++i) check(word.way[i].after_s >= word.way[i - 1].after_s);
}
void check_bounds(const OffersWord& word) {
  check(word.count <= word.offers.size());
  for (std::size_t i = 0; i < word.count; ++i) {
    check_place(word.offers[i].goal);
    check(word.offers[i].travel_s >= 0.0F && std::isfinite(word.offers[i].travel_s) && word.offers[i].gain_cells >= 0);
  }
}
void check_bounds(const StateWord& word) { check(word.battery_percent <= 100 && word.radius_m <= 10.0F); }
void check_bounds(const ContactWord& word) {
  check(word.heard_count <= word.heard.size());
  for (const RobotId robot : word.all_heard()) check(robot != 0 && word.hears(robot));
}
void check_bounds(const OrdersWord& word) {
  check(word.count <= word.orders.size());
  for (std::size_t i = 0; i < word.count; ++i) check_place(word.orders[i].goal);
}

StatusBytes first_bytes, second_bytes;

template <typename Word>
void take(ByteSpan payload) {
  Word word;
  if (read_status(payload, word) != StatusFault::none) return;
  check_bounds(word);
  write_status(word, first_bytes);
  check(first_bytes.bytes().size() <= std::min(payload.size(), kMostPayload_bytes));
  Word again;
  check(read_status(first_bytes.bytes(), again) == StatusFault::none);
  write_status(again, second_bytes);
  const ByteSpan a = first_bytes.bytes(), b = second_bytes.bytes();
  check(std::equal(a.begin(), a.end(), b.begin(), b.end()));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  const ByteSpan payload(data, size_bytes);
  take<MotionWord>(payload);
  take<OffersWord>(payload);
  take<StateWord>(payload);
  take<ContactWord>(payload);
  take<OrdersWord>(payload);
  return 0;
}
