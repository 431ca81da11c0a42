// SPDX-License-Identifier: Apache-2.0
#include "net/robot_status.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "hal/sim/seeded_random.hpp"
#include "net/wire_parts.hpp"

using namespace g3d;
using net::StatusFault;

namespace {

net::MotionWord driving_word() {
  net::MotionWord word;
  word.said_ms = 4'294'967'290U;
  word.T_world_base = {-12.345, 7.891, 3.0};
  word.is_moving = true;
  word.has_goal = true;
  word.goal = {3.2, -88.01, -1.5};
  word.way_count = 3;
  word.way[0] = {-12.35F, 7.89F, 0.0F};
  word.way[1] = {-11.0F, 7.5F, 4.5F};
  word.way[2] = {3.2F, -88.01F, 400.2F};
  return word;
}
net::OrdersWord two_orders() {
  net::OrdersWord word;
  word.term = 300;
  word.count = 2;
  word.orders[0] = {3, {1.0, 2.0, 0.5}};
  word.orders[1] = {0xFFFFFFFFFFFFFFFFULL, {-1.0, -2.0, -0.5}};
  return word;
}
net::ContactWord full_contact() {
  net::ContactWord word;
  word.office = {0x8000000000000001ULL, 70'000};
  word.heard_count = word.heard.size();
  for (std::size_t i = 0; i < word.heard.size(); ++i) word.heard[i] = (i + 1) << 56 | 5;
  return word;
}
net::OffersWord full_offers() {
  net::OffersWord word;
  word.count = word.offers.size();
  for (std::size_t i = 0; i < word.count; ++i) {
    const auto k = static_cast<float>(i);
    word.offers[i] = {{1.5 * k, -2.25 * k, 0.1 * k}, 3.5F * k, 1000.0F * k};
  }
  return word;
}

/// Every shorter payload and every longer one is refused, and leaves the word as it was.
template <typename Word>
void check_length(const Word& word, const Word& other) {
  net::StatusBytes bytes;
  net::write_status(word, bytes);
  net::StatusBytes before, after;
  net::write_status(other, before);
  for (std::size_t size = 0; size < bytes.bytes().size(); ++size) {
    Word read = other;
    CHECK(net::read_status(bytes.bytes().first(size), read) == StatusFault::truncated);
    net::write_status(read, after);
    REQUIRE(std::equal(before.bytes().begin(), before.bytes().end(), after.bytes().begin(), after.bytes().end()));
  }
  bytes.put_u8(0);
  Word read = other;
  CHECK(net::read_status(bytes.bytes(), read) == StatusFault::left_over);
}

void check_place(const hal::PlanarPose& read, const hal::PlanarPose& written) {
  CHECK(read.x_m == Approx(written.x_m).margin(0.0051));
  CHECK(read.y_m == Approx(written.y_m).margin(0.0051));
  CHECK(std::abs(std::remainder(read.heading_rad - written.heading_rad, 2.0 * std::numbers::pi)) < 1e-4);
}

}  // namespace

TEST_CASE("how a robot moves is told to a centimetre", "[net][status]") {
  const net::MotionWord word = driving_word();
  net::StatusBytes bytes;
  net::write_status(word, bytes);
  CHECK(bytes.bytes().size() < 45);
  net::MotionWord read;
  REQUIRE(net::read_status(bytes.bytes(), read) == StatusFault::none);
  CHECK(read.said_ms == word.said_ms);
  CHECK(read.is_moving);
  REQUIRE(read.has_goal);
  check_place(read.T_world_base, word.T_world_base);
  check_place(read.goal, word.goal);
  REQUIRE(read.way_count == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(read.way[i].x_m == Approx(word.way[i].x_m).margin(0.0051));
    CHECK(read.way[i].y_m == Approx(word.way[i].y_m).margin(0.0051));
    CHECK(read.way[i].after_s == Approx(word.way[i].after_s).margin(0.051));
  }
}

TEST_CASE("headings come back in (-pi, pi]", "[net][status]") {
  for (const double heading_rad : {std::numbers::pi, -std::numbers::pi, 7.0, -100.0, 0.0}) {
    net::MotionWord word;
    word.T_world_base.heading_rad = heading_rad;
    net::StatusBytes bytes;
    net::write_status(word, bytes);
    net::MotionWord read;
    REQUIRE(net::read_status(bytes.bytes(), read) == StatusFault::none);
    check_place(read.T_world_base, word.T_world_base);
    CHECK(read.T_world_base.heading_rad > -std::numbers::pi);
    CHECK(read.T_world_base.heading_rad <= std::numbers::pi);
  }
}

TEST_CASE("offers, state, contact and orders come back", "[net][status]") {
  net::StatusBytes bytes;
  const net::OffersWord offers = full_offers();
  net::write_status(offers, bytes);
  net::OffersWord offers_read;
  REQUIRE(net::read_status(bytes.bytes(), offers_read) == StatusFault::none);
  REQUIRE(offers_read.count == offers.count);
  for (std::size_t i = 0; i < offers.count; ++i) {
    check_place(offers_read.offers[i].goal, offers.offers[i].goal);
    CHECK(offers_read.offers[i].travel_s == Approx(offers.offers[i].travel_s));
    CHECK(offers_read.offers[i].gain_cells == Approx(offers.offers[i].gain_cells));
  }

  const net::StateWord state{nav::MissionState::returning, 87, 0.18F, 99};
  net::write_status(state, bytes);
  net::StateWord state_read;
  REQUIRE(net::read_status(bytes.bytes(), state_read) == StatusFault::none);
  CHECK(state_read.mission == state.mission);
  CHECK(state_read.battery_percent == 87);
  CHECK(state_read.radius_m == Approx(0.18F));
  CHECK(state_read.map_incarnation == 99);

  const net::ContactWord contact = full_contact();
  net::write_status(contact, bytes);
  CHECK(bytes.bytes().size() <= net::kMostPayload_bytes);
  net::ContactWord contact_read;
  REQUIRE(net::read_status(bytes.bytes(), contact_read) == StatusFault::none);
  CHECK(contact_read.office == contact.office);
  CHECK(contact_read.heard == contact.heard);
  CHECK(contact_read.hears(contact.heard[17]));
  CHECK_FALSE(contact_read.hears(4));

  const net::OrdersWord orders = two_orders();
  net::write_status(orders, bytes);
  net::OrdersWord orders_read;
  REQUIRE(net::read_status(bytes.bytes(), orders_read) == StatusFault::none);
  CHECK(orders_read.term == 300);
  REQUIRE(orders_read.count == 2);
  CHECK(orders_read.orders[1].robot == 0xFFFFFFFFFFFFFFFFULL);
  check_place(orders_read.orders[1].goal, orders.orders[1].goal);
}

TEST_CASE("a word that is cut or has something after it is refused as a whole", "[net][status]") {
  check_length(driving_word(), {});
  check_length(full_offers(), {});
  check_length(net::StateWord{nav::MissionState::home, 3, 0.2F, 7}, {});
  check_length(full_contact(), {});
  check_length(two_orders(), {});
}

TEST_CASE("what is out of its range is refused by its reason", "[net][status]") {
  net::StatusBytes bytes;
  net::MotionWord motion;
  bytes.put_u8(4);
  CHECK(net::read_status(bytes.bytes(), motion) == StatusFault::bad_flags);

  bytes.clear();
  bytes.put_u8(0);
  bytes.put_u32(0);
  bytes.put_varint(net::zigzag(10'000'001));
  bytes.put_varint(0);
  bytes.put_u16(0);
  CHECK(net::read_status(bytes.bytes(), motion) == StatusFault::bad_place);

  bytes.clear();
  bytes.put_u8(0);
  bytes.put_u32(0);
  bytes.put_place({});
  net::StatusBytes way = bytes;
  way.put_u8(nav::kMostWayPoints + 1);
  CHECK(net::read_status(way.bytes(), motion) == StatusFault::bad_count);
  // Two steps out of the world, of which one alone would do.
  way = bytes;
  way.put_u8(2);
  for (int i = 0; i < 2; ++i) {
    way.put_varint(net::zigzag(6'000'000));
    way.put_varint(0);
    way.put_varint(1);
  }
  CHECK(net::read_status(way.bytes(), motion) == StatusFault::bad_place);
  way = bytes;
  way.put_u8(1);
  way.put_varint(~std::uint64_t{0} >> 1);
  way.put_varint(0);
  way.put_varint(1);
  CHECK(net::read_status(way.bytes(), motion) == StatusFault::bad_place);
  way = bytes;
  way.put_u8(2);
  for (int i = 0; i < 2; ++i) {
    way.put_varint(0);
    way.put_varint(0);
    way.put_varint(600'000);
  }
  CHECK(net::read_status(way.bytes(), motion) == StatusFault::bad_number);

  bytes.clear();
  bytes.put_u8(nav::kMostOffers + 1);
  net::OffersWord offers;
  CHECK(net::read_status(bytes.bytes(), offers) == StatusFault::bad_count);

  bytes.clear();
  bytes.put_u8(static_cast<std::uint8_t>(nav::MissionState::needs_help) + 1);
  bytes.put_u8(3);
  net::StateWord state;
  CHECK(net::read_status(bytes.bytes(), state) == StatusFault::bad_number);
  bytes.clear();
  bytes.put_u8(0);
  bytes.put_u8(101);
  CHECK(net::read_status(bytes.bytes(), state) == StatusFault::bad_number);

  // A term without a leader, and a robot twice.
  bytes.clear();
  bytes.put_u64(0);
  bytes.put_varint(1);
  net::ContactWord contact;
  CHECK(net::read_status(bytes.bytes(), contact) == StatusFault::bad_number);
  bytes.clear();
  bytes.put_u64(0);
  bytes.put_varint(0);
  bytes.put_u8(2);
  bytes.put_u64(4);
  bytes.put_u64(4);
  CHECK(net::read_status(bytes.bytes(), contact) == StatusFault::bad_order);

  bytes.clear();
  bytes.put_varint(1);
  bytes.put_u8(1);
  bytes.put_u64(0);
  bytes.put_place({});
  net::OrdersWord orders;
  CHECK(net::read_status(bytes.bytes(), orders) == StatusFault::bad_order);
}

TEST_CASE("numbers that are none or too large are written as what can be read", "[net][status]") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  net::MotionWord word;
  word.T_world_base = {kNan, kInfinite, kNan};
  word.way_count = 1000;
  word.way[3] = {-std::numeric_limits<float>::infinity(), 1e30F, -5.0F};
  net::StatusBytes bytes;
  net::write_status(word, bytes);
  net::MotionWord read;
  REQUIRE(net::read_status(bytes.bytes(), read) == StatusFault::none);
  CHECK(read.T_world_base.x_m == 0.0);
  CHECK(read.T_world_base.y_m == net::kMostCoordinate_m);
  CHECK(read.way_count == nav::kMostWayPoints);
  net::OffersWord offers;
  offers.count = 1;
  offers.offers[0] = {{}, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()};
  net::write_status(offers, bytes);
  CHECK(net::read_status(bytes.bytes(), offers) == StatusFault::none);
  CHECK(std::isfinite(offers.offers[0].travel_s));
}

TEST_CASE("a word of any kind fits into a payload", "[net][status]") {
  net::StatusBytes bytes;
  net::OrdersWord orders;
  orders.term = std::uint64_t{1} << 48;
  orders.count = orders.orders.size();
  for (std::size_t i = 0; i < orders.count; ++i) orders.orders[i] = {i + 1, {-99'999.0, 99'999.0, 1.0}};
  net::write_status(orders, bytes);
  CHECK(bytes.bytes().size() <= net::kMostPayload_bytes);
  CHECK(net::read_status(bytes.bytes(), orders) == StatusFault::none);
  net::MotionWord motion;
  motion.has_goal = true;
  motion.way_count = motion.way.size();
  for (std::size_t i = 0; i < motion.way_count; ++i) {
    const float x_m = i % 2 == 0 ? -99'999.0F : 99'999.0F;
    motion.way[i] = {x_m, -x_m, static_cast<float>(i) * 5000.0F};
  }
  net::write_status(motion, bytes);
  CHECK(bytes.bytes().size() <= net::kMostPayload_bytes);
  CHECK(net::read_status(bytes.bytes(), motion) == StatusFault::none);
}
