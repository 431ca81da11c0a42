// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/packet_reader.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "hal/kobuki/odometry.hpp"
#include "hal/kobuki/packet_gates.hpp"
#include "tests/support/kobuki_packets.hpp"
#include "tests/support/temp_folder.hpp"

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

/// A drive in packets, as bytes; byte_of says where each begins, and where the last ends.
struct Recording {
  std::vector<Feedback> packets;
  Bytes bytes;
  std::vector<std::size_t> byte_of{0};

  void add_frame(const Bytes& frame) {
    PacketReader reader;
    const auto read = read_all(reader, frame);
    REQUIRE(read.size() == 1);
    packets.push_back(read[0]);
    add(bytes, frame);
    byte_of.push_back(bytes.size());
  }
};

/// On an arc, all wraps on the way, flags as given, one packet with answers.
Recording arc_recording(int packets, bool flags_set) {
  Recording recording;
  Packet packet{first_packet(), {}, {}};
  for (int i = 0; i < packets; ++i) {
    if (flags_set) packet.feedback.bumper = packet.feedback.cliff = 7;
    if (flags_set) packet.feedback.wheel_drop = packet.feedback.over_current = 3;
    packet.info.has_firmware = packet.info.has_udid = i == 2;
    Bytes frame(kMaxFrame_bytes);
    frame.resize(encode_feedback(packet, frame));
    recording.add_frame(frame);
    packet.feedback = packet_after(packet.feedback, 90, 110);
  }
  return recording;
}

Recording captured_recording() {
  Recording recording;
  for (const auto hex : {g3d::tests::kPacketK1, g3d::tests::kPacketK2, g3d::tests::kPacketK3}) {
    recording.add_frame(from_hex(hex));
  }
  return recording;
}

bool is_same(const Feedback& a, const Feedback& b) { return frame_of(a) == frame_of(b); }

double distance_m(const Odometry& a, const Odometry& b) {
  return std::hypot(a.T_world_base().x_m - b.T_world_base().x_m, a.T_world_base().y_m - b.T_world_base().y_m);
}

struct Damage {
  std::size_t lost = 0;  // packets of the recording that did not come out
  bool flags_held = true;
  double worst_step_m = 0.0;
  double end_error_m = 0.0, end_error_rad = 0.0;
};

Damage damage_of(const Recording& recording, const Bytes& damaged) {
  Damage damage;
  PacketReader reader;
  Odometry odometry, truth;
  std::size_t next = 0;  // packet of the recording that comes out next
  reader.feed(damaged, 0, [&](const Feedback& feedback) {
    const Odometry before = odometry;
    odometry.update(feedback);
    damage.worst_step_m = std::max(damage.worst_step_m, distance_m(before, odometry));
    damage.flags_held &= feedback.bumper == recording.packets[0].bumper &&
                         feedback.cliff == recording.packets[0].cliff &&
                         feedback.wheel_drop == recording.packets[0].wheel_drop &&
                         feedback.over_current == recording.packets[0].over_current;
    std::size_t found = next;
    while (found < recording.packets.size() && !is_same(feedback, recording.packets[found])) ++found;
    if (found == recording.packets.size()) return;
    damage.lost += found - next;
    next = found + 1;
  });
  damage.lost += recording.packets.size() - next;
  for (const Feedback& packet : recording.packets) truth.update(packet);
  damage.end_error_m = distance_m(odometry, truth);
  damage.end_error_rad = std::abs(odometry.T_world_base().heading_rad - truth.T_world_base().heading_rad);
  return damage;
}

void check_every_single_byte(const Recording& recording, std::size_t value_step) {
  const auto check = [&](const Bytes& damaged, std::size_t damaged_packets) {
    const Damage damage = damage_of(recording, damaged);
    if (damage.lost > damaged_packets + 1) FAIL_CHECK("lost " << damage.lost << " packets");
    if (!damage.flags_held) FAIL_CHECK("a flag was cleared");
  };
  for (std::size_t at = 0; at < recording.bytes.size(); ++at) {
    CAPTURE(at);
    Bytes damaged = recording.bytes;
    for (std::size_t change = 1; change < 256; change += value_step) {
      damaged[at] = static_cast<std::uint8_t>(recording.bytes[at] ^ change);
      check(damaged, 1);
    }
    damaged = recording.bytes;
    damaged.erase(damaged.begin() + static_cast<std::ptrdiff_t>(at));
    check(damaged, 1);
    const bool is_between = std::count(recording.byte_of.begin(), recording.byte_of.end(), at) != 0;
    damaged = recording.bytes;
    damaged.insert(damaged.begin() + static_cast<std::ptrdiff_t>(at), 0);
    for (std::size_t value = 0; value < 256; value += value_step) {
      damaged[at] = static_cast<std::uint8_t>(value);
      check(damaged, is_between ? 0 : 1);
    }
  }
}

TEST_CASE("one corrupted, lost or added byte costs at most one undamaged packet, captured packets") {
  check_every_single_byte(captured_recording(), 1);
}

TEST_CASE("one corrupted, lost or added byte costs at most one undamaged packet, an arc with answers") {
  check_every_single_byte(arc_recording(5, true), 3);
}

TEST_CASE("one corrupted, lost or added byte costs at most one undamaged packet, the capture as published") {
  const std::string folder = g3d::test::data_folder();
  if (folder.empty()) return;
  const std::string text = g3d::test::read_plain(folder + "/kobuki/feedback_packets.bin");
  const Bytes bytes(text.begin(), text.end());
  PacketReader reader;
  REQUIRE(read_all(reader, bytes).size() == 2);
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    Bytes shorter = bytes;
    shorter.erase(shorter.begin() + static_cast<std::ptrdiff_t>(at));
    PacketReader again;
    CAPTURE(at);
    // Between the two there is a stray byte that nobody misses.
    CHECK(read_all(again, shorter).size() >= (at == 81 ? 2U : 1U));
  }
}

TEST_CASE("two changed bytes that cancel in the checksum clear no flag, and their way is taken back", "[slow]") {
  const Recording recording = arc_recording(8, true);
  const std::size_t begin = recording.byte_of[3], end = recording.byte_of[4];
  const double gate_m = max_ticks_in(40) * kMetresPerTick;
  std::size_t slipped = 0;
  for (std::size_t first = begin + 3; first + 1 < end; ++first) {
    for (std::size_t second = first + 1; second + 1 < end; ++second) {
      for (const int change : {0x01, 0x02, 0x07, 0x40, 0x80, 0xFF}) {
        Bytes damaged = recording.bytes;
        damaged[first] = static_cast<std::uint8_t>(damaged[first] ^ change);
        damaged[second] = static_cast<std::uint8_t>(damaged[second] ^ change);
        const Damage damage = damage_of(recording, damaged);
        const bool is_good = damage.flags_held && damage.worst_step_m <= gate_m && damage.lost <= 3 &&
                             damage.end_error_m < 0.002 && damage.end_error_rad < 1e-9;
        if (damage.lost == 1) ++slipped;
        if (!is_good) {
          CAPTURE(first - begin, second - begin, change, damage.flags_held, damage.worst_step_m, damage.lost,
                  damage.end_error_m, damage.end_error_rad);
          FAIL_CHECK("more than the gates allow");
        }
      }
    }
  }
  CHECK(slipped > 1000);  // else this would prove nothing
}

TEST_CASE("ten minutes on a bad line: flags hold, and the way is that of a good line") {
  std::uint32_t seed = 5;
  const auto random = [&seed](std::uint32_t below) {
    seed = seed * 1664525U + 1013904223U;
    return static_cast<std::uint32_t>(std::uint64_t{seed} * below >> 32);
  };
  PacketReader reader;
  Odometry odometry, truth;
  Feedback packet = first_packet();
  std::size_t came = 0;
  for (int i = 0; i < 30'000; ++i) {
    packet.bumper = 2;
    packet.received_ns = i * kPacketPeriod_ns;
    truth.update(packet);
    Bytes frame = frame_of(packet);
    for (std::size_t at = 0; at < frame.size(); ++at) {
      if (random(400) != 0 || i == 29'999) continue;
      const std::uint32_t kind = random(3);
      const auto place = frame.begin() + static_cast<std::ptrdiff_t>(at);
      if (kind == 0) *place = static_cast<std::uint8_t>(random(256));
      if (kind == 1) frame.erase(place);
      if (kind == 2) frame.insert(place, static_cast<std::uint8_t>(random(256)));
    }
    reader.feed(frame, packet.received_ns, [&](const Feedback& feedback) {
      ++came;
      odometry.update(feedback);
      if (feedback.bumper != 2) FAIL_CHECK("the flag was cleared in packet " << i);
    });
    packet = packet_after(packet, 30 + i / 500 % 2 * 20, 50 - i / 500 % 2 * 20);
  }
  CHECK(came > 20'000);
  CHECK(came < 29'000);
  CHECK(reader.rejects()[Reject::bad_checksum] > 100);
  CHECK(distance_m(odometry, truth) < 0.02);
  CHECK(odometry.T_world_base().heading_rad == Approx(truth.T_world_base().heading_rad).margin(1e-9));
}

}  // namespace
