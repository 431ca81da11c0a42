// SPDX-License-Identifier: Apache-2.0
// The BaseDriver with a base at its other end, in lockstep, both in this process.
#pragma once

#include <cmath>
#include <vector>

#include "hal/kobuki/base_driver.hpp"
#include "tests/support/kobuki_packets.hpp"

namespace g3d::test {

inline bool is_still(const hal::Twist& t) { return t.forward_mps == 0.0 && t.turn_radps == 0.0; }

// A base that does at once what it is told, and a commander and a camera that are well until a test says otherwise.
struct DriverBench {
  hal::kobuki::BaseDriver driver;
  hal::kobuki::Feedback packet = tests::first_packet();
  hal::kobuki::CommandReader reader;
  std::vector<hal::kobuki::Command> heard;
  hal::Twist obeyed;
  hal::Twist wish;
  hal::TimeNs now_ns = 1'000'000'000;
  bool base = true, commander = true, camera = true, rear_is_free = true;

  explicit DriverBench(const hal::kobuki::BaseDriverOptions& options = {}) : driver(options) {}

  void hear(std::span<const std::uint8_t> bytes) {
    reader.feed(bytes, [&](const hal::kobuki::Command& command) {
      heard.push_back(command);
      if (command.base) obeyed = hal::kobuki::to_twist(*command.base);
    });
  }
  std::size_t tick() {
    std::array<std::uint8_t, hal::kobuki::BaseDriver::kMaxOut_bytes> out;
    const std::size_t size = driver.tick(now_ns, out);
    hear({out.data(), size});
    return size;
  }
  void next_packet() {
    const double left_mps = obeyed.forward_mps - obeyed.turn_radps * hal::kobuki::kWheelBase_m / 2;
    const double right_mps = obeyed.forward_mps + obeyed.turn_radps * hal::kobuki::kWheelBase_m / 2;
    packet = tests::packet_after(packet, static_cast<int>(std::lround(left_mps * 0.02 / hal::kobuki::kMetresPerTick)),
                                 static_cast<int>(std::lround(right_mps * 0.02 / hal::kobuki::kMetresPerTick)));
  }
  // One period: packet in, command out.
  void step() {
    now_ns += hal::kobuki::kPacketPeriod_ns;
    next_packet();
    if (base) driver.on_bytes(tests::frame_of(packet), now_ns);
    if (commander) driver.set_command(wish, now_ns);
    if (camera) driver.set_camera_alive(now_ns);
    if (rear_is_free) driver.set_rear_free(now_ns);
    tick();
  }
  void steps(int count) {
    for (int i = 0; i < count; ++i) step();
  }
  // A packet with the answers to what it was asked: firmware 1.2.0.
  void answer_versions() {
    now_ns += hal::kobuki::kPacketPeriod_ns;
    next_packet();
    hal::kobuki::Packet answer{packet, {}, {}};
    answer.info.has_hardware = answer.info.has_firmware = answer.info.has_udid = true;
    answer.info.hardware = {1, 0, 4};
    answer.info.firmware = {1, 2, 0};
    answer.info.udid = {1, 2, 3};
    std::vector<std::uint8_t> frame(hal::kobuki::kMaxFrame_bytes);
    frame.resize(hal::kobuki::encode_feedback(answer, frame));
    driver.on_bytes(frame, now_ns);
    tick();
  }
  const hal::kobuki::BaseState& state() const { return driver.state(); }
  bool has(hal::Condition c) const { return driver.state().conditions.has(c); }
};

}  // namespace g3d::test
