// SPDX-License-Identifier: Apache-2.0
// The kernels that tests run on have no CAN: a socket pair that carries the same frames stands for the bus. The real
// socket, link and controller are met in the emulated machine.
#include "hal/linux/can_socket.hpp"

#include <linux/can/error.h>

#include <catch2/catch.hpp>

#include "tests/support/scripted_can.hpp"

using namespace g3d;
using namespace g3d::hal;

TEST_CASE("Frames come and go as the kernel has them", "[can]") {
  const test::CanPair pair;
  CanSocket socket(pair.ours);
  can::CanFrame frame;
  CHECK_FALSE(socket.read(frame));
  pair.say(0x711, {5});
  pair.say(0x1F334455 | CAN_EFF_FLAG, {1, 2, 3});
  pair.say(0x123 | CAN_RTR_FLAG, {9, 9});
  REQUIRE(socket.read(frame));
  CHECK(frame.id == 0x711);
  CHECK(frame.size == 1);
  CHECK_FALSE(frame.is_extended);
  REQUIRE(socket.read(frame));
  CHECK(frame.id == 0x1F334455);
  CHECK(frame.is_extended);
  REQUIRE(socket.read(frame));
  CHECK(frame.is_remote);
  CHECK(frame.data == std::array<std::uint8_t, 8>{});  // carries none
  CHECK_FALSE(socket.read(frame));

  frame = {};
  frame.id = 0x18A;
  frame.size = 8;
  frame.data[7] = 7;
  REQUIRE(socket.write(frame));
  const auto heard = pair.hear();
  REQUIRE(heard);
  CHECK(heard->can_id == 0x18A);
  CHECK(heard->can_dlc == 8);
  CHECK(heard->data[7] == 7);
  frame.is_extended = true;
  REQUIRE(socket.write(frame));
  CHECK(pair.hear()->can_id == (0x18A | CAN_EFF_FLAG));
  CHECK(socket.counts().received == 3);
  CHECK(socket.counts().sent == 2);
}

TEST_CASE("What is no frame is dropped and counted", "[can]") {
  const test::CanPair pair;
  CanSocket socket(pair.ours);
  can_frame lying{};
  lying.can_id = 0x711;
  lying.can_dlc = 9;
  REQUIRE(::write(pair.bus, &lying, sizeof lying) == sizeof lying);
  REQUIRE(::write(pair.bus, "short", 5) == 5);
  const std::array<char, 72> flexible{};  // a frame of CAN FD
  REQUIRE(::write(pair.bus, flexible.data(), flexible.size()) == 72);
  pair.say(0x800, {1});  // more than 11 bits, though not extended
  pair.say(0x711, {5});
  can::CanFrame frame;
  REQUIRE(socket.read(frame));
  CHECK(frame.id == 0x711);
  CHECK(socket.counts().malformed == 4);
  CHECK(socket.counts().received == 1);
}

TEST_CASE("Bus-off is seen, and that it is over", "[can]") {
  const test::CanPair pair;
  CanSocket socket(pair.ours);
  can::CanFrame frame;
  pair.say(CAN_ERR_FLAG | CAN_ERR_BUSOFF, std::vector<std::uint8_t>(8, 0));
  REQUIRE(socket.read(frame));
  CHECK(frame.is_error);
  CHECK(socket.bus_is_off());
  CHECK(socket.counts().bus_offs == 1);
  pair.say(CAN_ERR_FLAG | CAN_ERR_RESTARTED, std::vector<std::uint8_t>(8, 0));
  REQUIRE(socket.read(frame));
  CHECK_FALSE(socket.bus_is_off());
  CHECK(socket.counts().bus_restarts == 1);
  pair.say(CAN_ERR_FLAG | CAN_ERR_BUSOFF, std::vector<std::uint8_t>(8, 0));
  pair.say(0x711, {5});  // whoever is heard is proof of a bus
  REQUIRE(socket.read(frame));
  REQUIRE(socket.read(frame));
  CHECK_FALSE(socket.bus_is_off());
  CHECK(socket.counts().error_frames == 3);
}

TEST_CASE("A full queue and a lost bus refuse frames and are counted", "[can]") {
  test::CanPair pair;
  CanSocket socket(pair.ours);
  can::CanFrame frame;
  frame.id = 0x70A;
  frame.size = 1;
  int sent = 0;
  while (sent < 100'000 && socket.write(frame)) ++sent;
  CHECK(socket.counts().send_queue_full == 1);
  CHECK(socket.counts().sent == static_cast<std::uint64_t>(sent));
  CHECK_FALSE(socket.needs_socket());
  pair.unplug();
  CHECK_FALSE(socket.write(frame));
  CHECK(socket.needs_socket());
  CHECK(socket.link_is_down());
  CHECK_FALSE(socket.write(frame));
  CHECK(socket.counts().not_sent_down == 2);
  CHECK(socket.counts().link_losses == 1);
}

TEST_CASE("A bus that is unplugged comes back as a new one", "[can]") {
  test::CanPair first;
  CanSocket socket(first.ours);
  can::CanFrame frame;
  first.unplug();
  CHECK_FALSE(socket.read(frame));
  CHECK(socket.needs_socket());
  const test::CanPair second, third;
  socket.hand_over(second.ours);
  CHECK_FALSE(socket.needs_socket());
  socket.hand_over(third.ours);  // the one that waited is closed
  third.say(0x711, {5});
  REQUIRE(socket.read(frame));
  CHECK(frame.id == 0x711);
  CHECK(socket.counts().reopened == 1);
  CHECK_FALSE(socket.link_is_down());
  CHECK(::send(second.bus, "x", 1, MSG_NOSIGNAL) < 0);
}

TEST_CASE("A CAN interface that is not there is an error with a remedy", "[can]") {
  const auto fd = open_can_socket("nocan7");
  REQUIRE_FALSE(fd.ok());
  // Which of the two depends on the kernel of this machine.
  CHECK((fd.error().reason == Reason::not_found || fd.error().reason == Reason::unsupported));
  CHECK(fd.error().text.find("nocan7: ") == 0);
}
