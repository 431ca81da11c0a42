// SPDX-License-Identifier: Apache-2.0
#include "tests/support/scripted_base.hpp"

#include <unistd.h>

#include "hal/clock.hpp"
#include "tests/support/kobuki_packets.hpp"

namespace g3d::test {

ScriptedBase::ScriptedBase(int fd) : fd_(fd), thread_([this] { run(); }) {}

ScriptedBase::~ScriptedBase() {
  ending_.store(true);
  thread_.join();
}

void ScriptedBase::set_flags(std::uint8_t bumper, std::uint8_t cliff, std::uint8_t wheel_drop) {
  flags_sent_ns_.store(0);
  // The top byte makes each call a new value, so that the thread sees it as one.
  const std::uint32_t turn = (flags_.load() >> 24) + 1;
  flags_.store(turn << 24 | static_cast<std::uint32_t>(bumper) << 16 | static_cast<std::uint32_t>(cliff) << 8 |
               wheel_drop);
}

void ScriptedBase::run() {
  hal::RealClock clock;
  hal::kobuki::Feedback packet = tests::first_packet();
  std::uint32_t told = 0;
  for (hal::TimeNs due_ns = clock.now(); !ending_.load(); due_ns += hal::kobuki::kPacketPeriod_ns) {
    clock.sleep_until(due_ns);
    packet = tests::packet_after(packet, ticks_.load(), ticks_.load());
    if (silent_.load()) continue;
    const std::uint32_t flags = flags_.load();
    packet.bumper = static_cast<std::uint8_t>(flags >> 16);
    packet.cliff = static_cast<std::uint8_t>(flags >> 8);
    packet.wheel_drop = static_cast<std::uint8_t>(flags);
    const auto frame = tests::frame_of(packet);
    // Before it is written: who sees the answer must find the time of the question.
    last_sent_ns_.store(clock.now());
    if (flags != told) flags_sent_ns_.store(clock.now());
    told = flags;
    (void)!::write(fd_, frame.data(), frame.size());
  }
}

}  // namespace g3d::test
