// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/command.hpp"

#include <catch2/catch.hpp>
#include <limits>
#include <string_view>
#include <vector>

#include "tests/support/kobuki_packets.hpp"

namespace {

using namespace g3d::hal;
using namespace g3d::hal::kobuki;
using g3d::tests::from_hex;
using Bytes = std::vector<std::uint8_t>;

Bytes encoded(const Command& command) {
  Bytes bytes(kMaxCommand_bytes);
  bytes.resize(encode_command(command, bytes));
  return bytes;
}

Bytes encoded(const Twist& twist) {
  Bytes bytes(kMaxCommand_bytes);
  bytes.resize(encode_base_control(twist, bytes));
  return bytes;
}

std::vector<Command> read_all(CommandReader& reader, const Bytes& bytes) {
  std::vector<Command> read;
  reader.feed(bytes, [&](const Command& command) { read.push_back(command); });
  return read;
}

Command full_command() {
  Command all;
  all.base = BaseControl{-257, -400};
  all.sound = Sound{826, 200};
  all.sound_sequence = SoundSequence::error;
  all.request_extra = kAskAll;
  all.outputs = kAllRails | kLed2Red;
  all.set_gains = ControllerGains{true, 1, 2, 3'000'000'000};
  all.get_gains = true;
  return all;
}

TEST_CASE("base control is sent as the published vectors say") {
  CHECK(encoded(Twist{0.0, 0.0}) == from_hex("aa 55 06 01 04 00 00 00 00 03"));
  CHECK(encoded(Twist{0.2, 0.0}) == from_hex("aa 55 06 01 04 c8 00 00 00 cb"));
  CHECK(encoded(Twist{-0.1, 0.0}) == from_hex("aa 55 06 01 04 9c ff 00 00 60"));
  CHECK(encoded(Twist{0.0, 1.0}) == from_hex("aa 55 06 01 04 73 00 01 00 71"));
  CHECK(encoded(Twist{0.0, -1.0}) == from_hex("aa 55 06 01 04 8d ff 01 00 70"));
  CHECK(encoded(Twist{0.2, 0.5}) == from_hex("aa 55 06 01 04 01 01 90 01 92"));
  CHECK(encoded(Twist{0.2, -0.5}) == from_hex("aa 55 06 01 04 01 01 70 fe 8d"));
  CHECK(encoded(Twist{-0.2, 0.5}) == from_hex("aa 55 06 01 04 ff fe 70 fe 8c"));
  CHECK(encoded(Twist{-0.1, -0.4}) == from_hex("aa 55 06 01 04 6e ff fa 00 68"));
  Command published;
  published.base = BaseControl{100, -100};
  CHECK(encoded(published) == from_hex("aa 55 06 01 04 64 00 9c ff 04"));
}

TEST_CASE("everything else is sent as the published vectors say") {
  Command command;
  command.request_extra = kAskAll;
  CHECK(encoded(command) == from_hex("aa 55 04 09 02 0b 00 04"));
  command = {};
  command.get_gains = true;
  CHECK(encoded(command) == from_hex("aa 55 03 0e 01 00 0c"));
  command = {};
  command.outputs = kAllRails | kLed1Green;
  CHECK(encoded(command) == from_hex("aa 55 04 0c 02 f0 02 f8"));
  command = {};
  command.sound_sequence = SoundSequence::error;
  CHECK(encoded(command) == from_hex("aa 55 03 04 01 04 02"));
  command = {};
  command.set_gains = ControllerGains{};
  CHECK(encoded(command) == from_hex("aa 55 0f 0d 0d 00 a0 86 01 00 64 00 00 00 d0 07 00 00 9b"));
  command = {};
  command.sound = sound_of(440.0, 200);
  CHECK(encoded(command) == from_hex("aa 55 05 03 03 3a 03 c8 f4"));
}

TEST_CASE("sounds stay within what a base can sound") {
  CHECK(sound_of(1.0, 5).note == sound_of(31.0, 5).note);
  CHECK(sound_of(1e9, 5).note == sound_of(20'000.0, 5).note);
  CHECK(sound_of(std::numeric_limits<double>::quiet_NaN(), 5).note > 0);
  CHECK(sound_of(440.0, 1000).duration_ms == 255);
  CHECK(sound_of(440.0, -1).duration_ms == 0);
}

TEST_CASE("no word turns the camera's rail off") {
  for (const int word : {0, 0x0F, 0x70, 0xF00}) {
    Command command;
    command.outputs = static_cast<std::uint16_t>(word);
    CommandReader reader;
    const auto read = read_all(reader, encoded(command));
    REQUIRE(read.size() == 1);
    CHECK(read[0].outputs == (word | kRail12V1A5));
  }
}

TEST_CASE("a command without parts is no frame") { CHECK(encoded(Command{}).empty()); }

TEST_CASE("a simulated base understands what is sent, however it is cut and whatever lies between") {
  Bytes stream{0xAA, 0x55, 0x06, 0x01};
  const Bytes all = encoded(full_command());
  const Bytes stop = encoded(Twist{});
  stream.insert(stream.end(), all.begin(), all.end());
  stream.push_back(0xAA);
  stream.insert(stream.end(), stop.begin(), stop.end());
  CommandReader reader;
  std::vector<Command> read;
  for (const std::uint8_t byte : stream) {
    reader.feed(std::span(&byte, 1), [&](const Command& command) { read.push_back(command); });
  }
  REQUIRE(read.size() == 2);
  CHECK(read[0] == full_command());
  CHECK(read[1].base == BaseControl{});
  CHECK(reader.rejects().accepted_frames == 2);
}

TEST_CASE("one changed bit and a command is none") {
  const Bytes good = encoded(full_command());
  for (std::size_t at = 0; at < good.size(); ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      Bytes bad = good;
      bad[at] = static_cast<std::uint8_t>(bad[at] ^ (1 << bit));
      CommandReader reader;
      CAPTURE(at, bit);
      CHECK(read_all(reader, bad).empty());
    }
  }
}

TEST_CASE("a frame with a wrong part is dropped as a whole") {
  const auto rejected_for = [](const char* hex) {
    Bytes frame = from_hex(hex);
    g3d::tests::repair_checksum(frame);
    CommandReader reader;
    CHECK(read_all(reader, frame).empty());
    CHECK(reader.rejects().total() == 1);
    for (std::size_t i = 0; i < kRejectCount; ++i) {
      if (reader.rejects().by_reason[i] != 0) return static_cast<Reject>(i);
    }
    return Reject::count_;
  };
  CHECK(rejected_for("aa 55 09 01 04 c8 00 00 00 04 01 07 00") == Reject::impossible_value);  // no eighth melody
  CHECK(rejected_for("aa 55 0c 01 04 c8 00 00 00 01 04 00 00 00 00 00") == Reject::duplicate_block);
  CHECK(rejected_for("aa 55 05 01 03 c8 00 00 00") == Reject::wrong_block_size);
  CHECK(rejected_for("aa 55 07 01 04 c8 00 00 00 63 00") == Reject::block_overruns);
  CommandReader reader;
  Bytes unknown = from_hex("aa 55 09 01 04 c8 00 00 00 63 01 07 00");
  g3d::tests::repair_checksum(unknown);
  const auto read = read_all(reader, unknown);
  REQUIRE(read.size() == 1);
  CHECK(read[0].base == BaseControl{200, 0});
}

}  // namespace
