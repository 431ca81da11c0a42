// SPDX-License-Identifier: Apache-2.0
#include "net/status_book.hpp"

#include <catch2/catch.hpp>

using namespace g3d;
using net::StatusBook;
using net::StatusKind;

namespace {

template <typename Word>
void tell(net::LayerStore& store, const net::LayerId& id, StatusKind kind, net::Version version, const Word& word) {
  net::StatusBytes bytes;
  net::write_status(word, bytes);
  const net::LayerIndex layer = store.find_or_add(id);
  REQUIRE(store.put(layer, net::status_key(kind), version, net::Lane::ground, bytes.bytes()) ==
          net::LayerStore::Put::stored);
}
net::MotionWord at_place(double x_m, std::uint32_t said_ms) {
  net::MotionWord word;
  word.T_world_base.x_m = x_m;
  word.said_ms = said_ms;
  return word;
}

}  // namespace

TEST_CASE("the newest word of each kind is in the book, with the time at which it came", "[net][status]") {
  net::LayerStore store({8, 64, 1 << 16, 16});
  StatusBook book(1, 4);
  tell(store, {2, 1}, StatusKind::motion, 1, at_place(3.0, 100));
  tell(store, {2, 1}, StatusKind::state, 2, net::StateWord{nav::MissionState::paused, 44, 0.2F, 1});
  tell(store, {1, 1}, StatusKind::motion, 1, at_place(9.0, 100));
  book.update(store, 7'000);
  CHECK(book.find(1) == nullptr);
  const net::RobotWords* words = book.find(2);
  REQUIRE(words != nullptr);
  CHECK(words->motion.T_world_base.x_m == 3.0);
  CHECK(words->moved_ns == 7'000);
  CHECK(words->state.battery_percent == 44);
  CHECK(words->has(StatusKind::motion));
  CHECK_FALSE(words->has(StatusKind::contact));
  CHECK(book.counts().words == 2);
  // What is not new is not read again.
  book.update(store, 8'000);
  CHECK(words->moved_ns == 7'000);
  tell(store, {2, 1}, StatusKind::motion, 3, at_place(4.0, 100));
  book.update(store, 9'000);
  CHECK(words->motion.T_world_base.x_m == 4.0);
  CHECK(book.counts().words == 3);
}

TEST_CASE("a robot's new layer makes its old words void, and old layers come too late", "[net][status]") {
  net::LayerStore store({8, 64, 1 << 16, 16});
  StatusBook book(1, 4);
  net::ContactWord contact;
  contact.office = {2, 5};
  tell(store, {2, 3}, StatusKind::contact, 9, contact);
  book.update(store, 0);
  CHECK(book.find(2)->contact.office.term == 5);
  tell(store, {2, 4}, StatusKind::motion, 1, at_place(4.0, 0));
  book.update(store, 0);
  CHECK(book.find(2)->layer.incarnation == 4);
  CHECK_FALSE(book.find(2)->has(StatusKind::contact));
  contact.office.term = 6;
  tell(store, {2, 3}, StatusKind::contact, 10, contact);
  book.update(store, 0);
  CHECK_FALSE(book.find(2)->has(StatusKind::contact));
  CHECK(book.all().size() == 1);
}

TEST_CASE("a word that cannot be read is counted by its reason, and the one before stands", "[net][status]") {
  net::LayerStore store({8, 64, 1 << 16, 16});
  StatusBook book(1, 4);
  tell(store, {2, 1}, StatusKind::motion, 1, at_place(3.0, 0));
  book.update(store, 0);
  const std::array<std::uint8_t, 2> bytes{255, 0};
  REQUIRE(store.put(store.find({2, 1}), net::status_key(StatusKind::motion), 2, net::Lane::ground, bytes) ==
          net::LayerStore::Put::stored);
  book.update(store, 0);
  CHECK(book.find(2)->motion.T_world_base.x_m == 3.0);
  CHECK(book.counts().faults[static_cast<std::size_t>(net::StatusFault::bad_flags)] == 1);
  // It is looked at once.
  book.update(store, 0);
  CHECK(book.counts().faults[static_cast<std::size_t>(net::StatusFault::bad_flags)] == 1);
}

TEST_CASE("more robots than there is room for are left out and counted", "[net][status]") {
  net::LayerStore store({8, 64, 1 << 16, 16});
  StatusBook book(1, 2);
  for (net::RobotId robot = 2; robot <= 4; ++robot) {
    tell(store, {robot, 1}, StatusKind::motion, 1, at_place(static_cast<double>(robot), 0));
  }
  book.update(store, 0);
  CHECK(book.all().size() == 2);
  CHECK(book.find(4) == nullptr);
  CHECK(book.counts().left_out_robots == 1);
}
