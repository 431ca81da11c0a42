// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/packet_reader.hpp"

#include <catch2/catch.hpp>
#include <vector>

#include "hal/kobuki/packet_gates.hpp"
#include "tests/support/kobuki_packets.hpp"

namespace {

using namespace g3d::hal::kobuki;
using g3d::tests::first_packet;
using g3d::tests::frame_of;
using g3d::tests::from_hex;
using g3d::tests::packet_after;
using Bytes = std::vector<std::uint8_t>;

void add(Bytes& stream, const Bytes& more) { stream.insert(stream.end(), more.begin(), more.end()); }

std::vector<Feedback> read_all(PacketReader& reader, std::span<const std::uint8_t> bytes) {
  std::vector<Feedback> read;
  reader.feed(bytes, 7, [&](const Feedback& feedback) { read.push_back(feedback); });
  return read;
}

TEST_CASE("three packets of a real base come out one after another") {
  Bytes stream;
  for (const auto hex : {g3d::tests::kPacketK1, g3d::tests::kPacketK2, g3d::tests::kPacketK3})
    add(stream, from_hex(hex));
  PacketReader reader;
  const auto read = read_all(reader, stream);
  REQUIRE(read.size() == 3);
  CHECK(read[0].timestamp_ms == 61840);
  CHECK(read[1].timestamp_ms == 61860);
  CHECK(read[2].timestamp_ms == 61880);
  CHECK(read[2].received_ns == 7);
  CHECK(reader.rejects().total() == 0);
  CHECK(reader.rejects().skipped_bytes == 0);
  CHECK(reader.restarts() == 0);
}

TEST_CASE("how the bytes are cut makes no difference") {
  Bytes stream{0xA1, 0x00, 0xAA};
  for (const auto hex : {g3d::tests::kPacketK1, g3d::tests::kPacketK2, g3d::tests::kPacketK3}) {
    add(stream, from_hex(hex));
    add(stream, {0x55, 0xAA, 0x55, 0x4D, 0x01});
  }
  for (std::size_t step = 1; step < stream.size(); step += 1 + step / 8) {
    PacketReader reader;
    std::size_t count = 0;
    for (std::size_t at = 0; at < stream.size(); at += step) {
      const auto part = std::span(stream).subspan(at, std::min(step, stream.size() - at));
      reader.feed(part, 0, [&](const Feedback&) { ++count; });
    }
    CAPTURE(step);
    CHECK(count == 3);
  }
}

TEST_CASE("a packet is there with its last byte, not later") {
  const Bytes frame = from_hex(g3d::tests::kPacketK1);
  PacketReader reader;
  CHECK(read_all(reader, std::span(frame).first(frame.size() - 1)).empty());
  CHECK(read_all(reader, std::span(frame).last(1)).size() == 1);
}

TEST_CASE("firmware from before 1.0 is rejected as a whole") {
  PacketReader reader;
  CHECK(read_all(reader, from_hex(g3d::tests::kPacketK5)).empty());
  CHECK(reader.rejects()[Reject::wrong_block_size] == 1);
  CHECK(reader.rejects().total() == 1);
  // Nothing of it has become a reference: the next base is believed at once.
  CHECK(read_all(reader, from_hex(g3d::tests::kPacketK4)).size() == 1);
}

TEST_CASE("remnants that users report cost nothing but themselves") {
  for (const char* hex :
       {"e1aa554d010f", "2aaa554d010f", "3faa554d010fc0e8000000", "554d010f649e00000039097c", "dcaa5553010f10b2"}) {
    Bytes stream = from_hex(hex);
    add(stream, from_hex(g3d::tests::kPacketK1));
    add(stream, from_hex(hex));
    add(stream, from_hex(g3d::tests::kPacketK2));
    PacketReader reader;
    CAPTURE(hex);
    CHECK(read_all(reader, stream).size() == 2);
  }
}

TEST_CASE("a flag is set by one packet and cleared by two that agree") {
  const auto flags_of = [](const std::vector<int>& raw) {
    PacketReader reader;
    Feedback packet = first_packet();
    std::vector<int> seen;
    for (const int flag : raw) {
      packet = packet_after(packet, 5, 5);
      packet.bumper = packet.cliff = static_cast<std::uint8_t>(flag != 0 ? 2 : 0);
      packet.wheel_drop = packet.over_current = static_cast<std::uint8_t>(flag != 0 ? 1 : 0);
      for (const Feedback& f : read_all(reader, frame_of(packet))) {
        CHECK(f.bumper == f.cliff);
        CHECK(f.wheel_drop == f.over_current);
        CHECK((f.bumper != 0) == (f.wheel_drop != 0));
        seen.push_back(f.bumper != 0 ? 1 : 0);
      }
    }
    return seen;
  };
  CHECK(flags_of({0, 1, 0, 0, 0}) == std::vector{0, 1, 1, 0, 0});
  CHECK(flags_of({1, 1, 0, 1, 1}) == std::vector{1, 1, 1, 1, 1});
  CHECK(flags_of({0, 0, 0}) == std::vector{0, 0, 0});
}

TEST_CASE("one packet that cannot follow is dropped, and the next true one is believed") {
  PacketReader reader;
  const Feedback first = first_packet();
  REQUIRE(read_all(reader, frame_of(first)).size() == 1);
  Feedback wrong = packet_after(first, 10, 10);
  wrong.left_encoder_ticks = static_cast<std::uint16_t>(wrong.left_encoder_ticks + 5000);
  CHECK(read_all(reader, frame_of(wrong)).empty());
  CHECK(reader.rejects()[Reject::encoder_step] == 1);
  const Feedback next = packet_after(packet_after(first, 10, 10), 10, 10);
  CHECK(read_all(reader, frame_of(next)).size() == 1);
  CHECK(reader.restarts() == 0);
}

TEST_CASE("a restarted base is believed at its second packet") {
  PacketReader reader;
  REQUIRE(read_all(reader, frame_of(first_packet())).size() == 1);
  Feedback restarted = first_packet();
  restarted.timestamp_ms = 40;
  restarted.left_encoder_ticks = restarted.right_encoder_ticks = 0;
  restarted.gyro_angle_cdeg = 0;
  CHECK(read_all(reader, frame_of(restarted)).empty());
  CHECK(read_all(reader, frame_of(packet_after(restarted, 0, 0))).size() == 1);
  CHECK(reader.restarts() == 1);
}

TEST_CASE("a base that repeats its last packet is silent") {
  PacketReader reader;
  const Bytes frame = frame_of(first_packet());
  REQUIRE(read_all(reader, frame).size() == 1);
  for (int i = 0; i < 100; ++i) CHECK(read_all(reader, frame).empty());
  CHECK(reader.rejects()[Reject::time_step] == 100);
}

TEST_CASE("answers are kept, until the line is lost") {
  PacketReader reader;
  Packet packet{first_packet(), {}, {}};
  packet.info = {true, true, true, {1, 0, 4}, {1, 2, 0}, {97713968, 842422349, 1361404194}};
  packet.gains = ControllerGains{};
  Bytes frame(kMaxFrame_bytes);
  frame.resize(encode_feedback(packet, frame));
  REQUIRE(read_all(reader, frame).size() == 1);
  REQUIRE(read_all(reader, frame_of(packet_after(packet.feedback, 1, 1))).size() == 1);
  CHECK(reader.info().has_firmware);
  CHECK(reader.info().firmware == std::array<std::uint8_t, 3>{1, 2, 0});
  CHECK(reader.info().udid[2] == 1361404194);
  CHECK(reader.gains() == ControllerGains{});
  reader.line_was_lost();
  CHECK_FALSE(reader.info().has_firmware);
  CHECK_FALSE(reader.gains());
}

}  // namespace
