// SPDX-License-Identifier: Apache-2.0
#include "hal/can/canopen.hpp"

#include <catch2/catch.hpp>

using namespace g3d::hal::can;

namespace {

CanFrame frame_with(std::uint32_t id, std::initializer_list<std::uint8_t> data) {
  CanFrame frame;
  frame.id = id;
  for (const std::uint8_t byte : data) frame.data[frame.size++] = byte;
  return frame;
}
NoMessage reason_of(const CanFrame& frame) {
  const Message message = decode(frame);
  const auto* reason = std::get_if<NoMessage>(&message);
  return reason != nullptr ? *reason : NoMessage::count_;
}

}  // namespace

TEST_CASE("Heartbeats are those of CiA 301", "[can]") {
  // Bytes as a node on a bus says them, not as our own encoder does.
  const Message operational = decode(frame_with(0x711, {0x05}));
  REQUIRE(std::holds_alternative<Heartbeat>(operational));
  CHECK(std::get<Heartbeat>(operational) == Heartbeat{0x11, NmtState::operational});
  CHECK(std::get<Heartbeat>(decode(frame_with(0x701, {0x00}))).state == NmtState::boot_up);
  CHECK(std::get<Heartbeat>(decode(frame_with(0x77F, {0x7F}))) == Heartbeat{127, NmtState::pre_operational});
  CHECK(reason_of(frame_with(0x711, {0x85})) == NoMessage::unknown_value);  // node guarding's toggle bit
  CHECK(reason_of(frame_with(0x711, {})) == NoMessage::bad_size);
  CHECK(reason_of(frame_with(0x711, {0x05, 0x00})) == NoMessage::bad_size);
  CHECK(reason_of(frame_with(0x700, {0x05})) == NoMessage::other);  // no node has the number 0
  CHECK(encode(Heartbeat{0x11, NmtState::stopped}) == frame_with(0x711, {0x04}));
}

TEST_CASE("An emergency says what stands and what is over", "[can]") {
  const Message message = decode(frame_with(0x091, {0x01, 0xFF, 0x81, 1, 2, 3, 4, 5}));
  REQUIRE(std::holds_alternative<Emergency>(message));
  const auto& emergency = std::get<Emergency>(message);
  CHECK(emergency == Emergency{0x11, 0xFF01, 0x81, {1, 2, 3, 4, 5}});
  CHECK_FALSE(emergency.is_all_clear());
  CHECK(std::get<Emergency>(decode(frame_with(0x091, {0, 0, 0, 0, 0, 0, 0, 0}))).is_all_clear());
  // One of two errors is over.
  CHECK_FALSE(std::get<Emergency>(decode(frame_with(0x091, {0, 0, 0x01, 0, 0, 0, 0, 0}))).is_all_clear());
  CHECK(reason_of(frame_with(0x091, {0, 0, 0})) == NoMessage::bad_size);
  CHECK(reason_of(frame_with(0x080, {0, 0, 0, 0, 0, 0, 0, 0})) == NoMessage::other);  // SYNC
  CHECK(encode(emergency) == frame_with(0x091, {0x01, 0xFF, 0x81, 1, 2, 3, 4, 5}));
}

TEST_CASE("Network management orders go to one node or to all", "[can]") {
  CHECK(std::get<NmtOrder>(decode(frame_with(0, {0x01, 0x11}))) == NmtOrder{NmtCommand::start, 0x11});
  CHECK(std::get<NmtOrder>(decode(frame_with(0, {0x80, 0}))).command == NmtCommand::enter_pre_operational);
  CHECK(reason_of(frame_with(0, {0x03, 0x11})) == NoMessage::unknown_value);
  CHECK(reason_of(frame_with(0, {0x01, 0x80})) == NoMessage::unknown_value);
  CHECK(reason_of(frame_with(0, {0x01})) == NoMessage::bad_size);
  CHECK(encode(NmtOrder{NmtCommand::stop, 7}) == frame_with(0, {0x02, 7}));
}

TEST_CASE("Other frames are no messages", "[can]") {
  CanFrame frame = frame_with(0x711, {0x05});
  frame.is_extended = true;
  CHECK(reason_of(frame) == NoMessage::not_canopen);
  frame.is_extended = false;
  frame.is_remote = true;
  CHECK(reason_of(frame) == NoMessage::not_canopen);
  frame.is_remote = false;
  frame.is_error = true;
  CHECK(reason_of(frame) == NoMessage::not_canopen);
  CHECK(reason_of(frame_with(0x601, {0x40, 0, 0x10, 0, 0, 0, 0, 0})) == NoMessage::other);
}

TEST_CASE("The robot's status survives the bus", "[can]") {
  const RobotStatus status{10, 5, 0x8001, -123, 2345, 148};
  const CanFrame frame = encode(status);
  CHECK(frame == frame_with(0x18A, {5, 0x01, 0x80, 0x85, 0xFF, 0x29, 0x09, 148}));
  RobotStatus read;
  REQUIRE(decode_status(frame, read));
  CHECK(read == status);
  CHECK_FALSE(decode_status(frame_with(0x18A, {1, 2}), read));
  CHECK_FALSE(decode_status(frame_with(0x180, {1, 2, 3, 4, 5, 6, 7, 8}), read));
}
