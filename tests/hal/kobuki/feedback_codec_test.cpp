// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/feedback_codec.hpp"

#include <catch2/catch.hpp>
#include <string_view>
#include <vector>

#include "tests/support/kobuki_packets.hpp"

namespace {

using namespace g3d::hal::kobuki;
using g3d::tests::from_hex;
using Bytes = std::vector<std::uint8_t>;
using Version = std::array<std::uint8_t, 3>;

std::span<const std::uint8_t> payload_of(const Bytes& frame) { return std::span(frame).subspan(3, frame.size() - 4); }

Packet decoded(std::string_view hex) {
  const Bytes frame = from_hex(hex);
  Packet packet;
  REQUIRE_FALSE(decode_feedback(payload_of(frame), packet));
  return packet;
}

/// K1 with more bytes at the end of its payload.
std::optional<Reject> verdict_with(std::string_view more, Packet& packet) {
  Bytes frame = from_hex(g3d::tests::kPacketK1);
  frame.pop_back();
  const Bytes added = from_hex(more);
  frame.insert(frame.end(), added.begin(), added.end());
  return decode_feedback(std::span(frame).subspan(3), packet);
}

TEST_CASE("the first captured packet, field by field") {
  const Feedback f = decoded(g3d::tests::kPacketK1).feedback;
  CHECK(f.timestamp_ms == 61840);
  CHECK((f.bumper == 0 && f.wheel_drop == 0 && f.cliff == 0 && f.buttons == 0 && f.over_current == 0));
  CHECK(f.left_encoder_ticks == 11245);
  CHECK(f.right_encoder_ticks == 18264);
  CHECK(f.left_pwm == 13);
  CHECK(f.right_pwm == 13);
  CHECK(f.charger == 18);
  CHECK(f.battery_decivolts == 159);
  CHECK(f.gyro_angle_cdeg == 7484);
  CHECK(f.gyro_rate_cdegps == -4);
  CHECK(f.cliff_adc == std::array<std::uint16_t, 3>{1781, 2041, 1680});
  CHECK(f.current_10mA == std::array<std::uint8_t, 2>{1, 1});
  CHECK(f.gyro_frame_id == 129);
  REQUIRE(f.gyro_sample_count == 2);
  CHECK((f.gyro[0].x == -95 && f.gyro[0].y == 8 && f.gyro[0].z == -56));
  CHECK((f.gyro[1].x == -112 && f.gyro[1].y == 3 && f.gyro[1].z == -49));
  CHECK(f.digital_in == 0x000F);
  CHECK(f.analog_in == std::array<std::uint16_t, 4>{4060, 4064, 4064, 4064});
}

TEST_CASE("the other captured packets") {
  const Feedback k2 = decoded(g3d::tests::kPacketK2).feedback;
  CHECK((k2.timestamp_ms == 61860 && k2.left_encoder_ticks == 11252 && k2.right_encoder_ticks == 18272));
  CHECK((k2.gyro_angle_cdeg == 7485 && k2.gyro_rate_cdegps == 33 && k2.gyro_frame_id == 131));
  const Feedback k3 = decoded(g3d::tests::kPacketK3).feedback;
  CHECK((k3.timestamp_ms == 61880 && k3.left_encoder_ticks == 11260 && k3.right_encoder_ticks == 18279));
  CHECK((k3.gyro_angle_cdeg == 7486 && k3.gyro_rate_cdegps == 79 && k3.gyro_frame_id == 133));
  const Feedback k4 = decoded(g3d::tests::kPacketK4).feedback;
  CHECK((k4.timestamp_ms == 2984 && k4.left_encoder_ticks == 65532 && k4.right_encoder_ticks == 62447));
  CHECK((k4.charger == 0 && k4.battery_decivolts == 157 && k4.gyro_angle_cdeg == -6245));
}

TEST_CASE("what a real base said is said again, but for bytes without meaning") {
  for (const auto hex : {g3d::tests::kPacketK1, g3d::tests::kPacketK2, g3d::tests::kPacketK3, g3d::tests::kPacketK4}) {
    Bytes real = from_hex(hex);
    for (std::size_t i = real.size() - 7; i + 1 < real.size(); ++i) real[i] = 0;  // unused analog inputs
    g3d::tests::repair_checksum(real);
    CHECK(g3d::tests::frame_of(decoded(hex).feedback) == real);
  }
}

TEST_CASE("old firmware's core block is no core block, and nothing of it is handed out") {
  const Bytes frame = from_hex(g3d::tests::kPacketK5);
  Packet packet;
  packet.feedback.timestamp_ms = 4711;
  CHECK(decode_feedback(payload_of(frame), packet) == Reject::wrong_block_size);
  CHECK(packet.feedback.timestamp_ms == 4711);
}

TEST_CASE("answers come with any packet") {
  Packet packet;
  REQUIRE_FALSE(verdict_with("0a 04 04 00 01 00  0b 04 00 02 01 00  13 0c 33ffda054d54393741631951", packet));
  CHECK(packet.info.hardware == Version{1, 0, 4});
  CHECK(packet.info.firmware == Version{1, 2, 0});
  CHECK(packet.info.udid == std::array<std::uint32_t, 3>{98238259, 926504013, 1360618305});
  REQUIRE_FALSE(verdict_with("15 0d 01 a0860100 64000000 d0070000", packet));
  CHECK(packet.gains == ControllerGains{true, 100'000, 100, 2'000});
  CHECK_FALSE(packet.info.has_firmware);
}

TEST_CASE("very old bases tell their versions in two bytes") {
  const auto firmware = [](const char* hex) {
    Packet packet;
    REQUIRE_FALSE(verdict_with(hex, packet));
    return packet.info.firmware;
  };
  CHECK(firmware("0b 02 7b 00") == Version{1, 0, 0});
  CHECK(firmware("0b 02 6e 00") == Version{1, 1, 0});
  CHECK(firmware("0b 02 74 27") == Version{1, 1, 0});
  CHECK(firmware("0b 02 6f 00") == Version{1, 1, 1});
  CHECK(firmware("0b 02 75 27") == Version{1, 1, 1});
  Packet packet;
  REQUIRE_FALSE(verdict_with("0a 02 68 00", packet));
  CHECK(packet.info.hardware == Version{1, 0, 4});
}

TEST_CASE("unknown and reserved blocks are skipped") {
  Packet packet;
  CHECK_FALSE(verdict_with("02 00  07 03 010203  63 01 ff  f0 00", packet));
  CHECK(packet.feedback.timestamp_ms == 61840);
}

TEST_CASE("a payload with one wrong block is rejected as a whole") {
  Packet packet;
  packet.feedback.timestamp_ms = 4711;
  CHECK(verdict_with("06 02 01 01", packet) == Reject::duplicate_block);
  CHECK(verdict_with("63", packet) == Reject::block_overruns);
  CHECK(verdict_with("63 02 00", packet) == Reject::block_overruns);
  CHECK(verdict_with("13 0b 33ffda054d543937416319", packet) == Reject::wrong_block_size);
  CHECK(verdict_with("0a 03 04 00 01", packet) == Reject::wrong_block_size);
  CHECK(packet.feedback.timestamp_ms == 4711);
}

TEST_CASE("raw gyro of any length that is not three numbers per sample is rejected") {
  const Bytes real = from_hex(g3d::tests::kPacketK1);
  const std::size_t at = 3 + 17 + 5 + 9 + 8 + 4;  // ID of the gyro block
  REQUIRE(real[at] == 13);
  for (int size = 0; size < 130; ++size) {
    for (const int numbers : {0, 3, 6, 9, 24, 27, 126, (size - 2) / 2}) {
      Bytes payload(real.begin() + 3, real.begin() + static_cast<std::ptrdiff_t>(at));
      payload.push_back(13);
      payload.push_back(static_cast<std::uint8_t>(size));
      if (size > 0) payload.push_back(200);
      if (size > 1) payload.push_back(static_cast<std::uint8_t>(numbers));
      payload.insert(payload.end(), static_cast<std::size_t>(std::max(0, size - 2)), 0x11);
      payload.insert(payload.end(), real.begin() + static_cast<std::ptrdiff_t>(at + 16), real.end() - 1);
      Packet packet;
      const bool is_right = size >= 2 && size == 2 + 2 * numbers && numbers % 3 == 0 && numbers <= 24;
      CAPTURE(size, numbers);
      CHECK(decode_feedback(payload, packet).has_value() == !is_right);
      if (is_right) CHECK(packet.feedback.gyro_sample_count == numbers / 3);
    }
  }
}

TEST_CASE("every block that each packet has must be there") {
  const Bytes real = from_hex(g3d::tests::kPacketK1);
  const std::span<const std::uint8_t> payload = payload_of(real);
  std::span<const std::uint8_t> rest = payload;
  Block block;
  std::size_t from = 0;
  int blocks = 0;
  while (take_block(rest, block)) {
    Bytes without(payload.begin(), payload.begin() + static_cast<std::ptrdiff_t>(from));
    from += 2 + block.data.size();
    without.insert(without.end(), payload.begin() + static_cast<std::ptrdiff_t>(from), payload.end());
    Packet packet;
    CAPTURE(int{block.id});
    const auto verdict = decode_feedback(without, packet);
    if (block.id == 13) {
      CHECK_FALSE(verdict);
      CHECK(packet.feedback.gyro_sample_count == 0);
    } else {
      CHECK(verdict == Reject::missing_block);
    }
    ++blocks;
  }
  CHECK(blocks == 7);
}

TEST_CASE("the longest packet there can be fits") {
  Packet longest{g3d::tests::first_packet(), {}, ControllerGains{}};
  longest.feedback.gyro_sample_count = 8;
  longest.feedback.gyro[7] = {-1, 2, -3};
  longest.info.has_hardware = longest.info.has_firmware = longest.info.has_udid = true;
  Bytes frame(kMaxFrame_bytes);
  frame.resize(encode_feedback(longest, frame));
  Packet packet;
  REQUIRE_FALSE(decode_feedback(payload_of(frame), packet));
  CHECK(packet.feedback.gyro[7].z == -3);
  CHECK(packet.gains == ControllerGains{});
}

}  // namespace
