// SPDX-License-Identifier: Apache-2.0
#include "tests/support/command_tap.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <ctime>

namespace g3d::test {
namespace {

constexpr std::size_t kPayloadAt = 3;

const std::uint8_t* base_control(const std::vector<std::uint8_t>& bytes) {
  for (std::size_t at = kPayloadAt; at + 2 < bytes.size(); at += 2 + bytes[at + 1]) {
    if (bytes[at] == 1 && bytes[at + 1] == 4 && at + 6 < bytes.size()) return &bytes[at + 2];
  }
  return nullptr;
}

}  // namespace

bool SentPacket::is_base_control() const { return base_control(bytes) != nullptr; }

bool SentPacket::is_zero_speed() const {
  const std::uint8_t* const control = base_control(bytes);
  return control != nullptr && control[0] == 0 && control[1] == 0;
}

bool CommandTap::take(SentPacket& packet) {
  for (;;) {
    const std::array<std::uint8_t, 2> header{0xaa, 0x55};
    const auto start = std::search(pending_.begin(), pending_.end(), header.begin(), header.end());
    if (start == pending_.end()) return false;
    pending_.erase(pending_.begin(), start);
    if (pending_.size() < kPayloadAt) return false;
    const std::size_t size = kPayloadAt + pending_[2] + 1;
    if (pending_.size() < size) return false;
    std::uint8_t check = 0;
    for (std::size_t i = 2; i < size; ++i) check ^= pending_[i];
    if (check != 0) {
      pending_.erase(pending_.begin());
      continue;
    }
    packet.bytes.assign(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(size));
    packet.t_ns = clock_.now();
    pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(size));
    return true;
  }
}

bool CommandTap::next(SentPacket& packet, hal::TimeNs timeout_ns) {
  const hal::TimeNs end_ns = clock_.now() + timeout_ns;
  while (!take(packet)) {
    const hal::TimeNs left_ns = end_ns - clock_.now();
    if (left_ns <= 0) return false;
    pollfd poll_fd{fd_, POLLIN, 0};
    const timespec timeout{static_cast<std::time_t>(left_ns / 1'000'000'000),
                           static_cast<long>(left_ns % 1'000'000'000)};
    if (::ppoll(&poll_fd, 1, &timeout, nullptr) <= 0) continue;
    std::array<std::uint8_t, 512> buffer;
    const ssize_t count = ::read(fd_, buffer.data(), buffer.size());
    if (count > 0) pending_.insert(pending_.end(), buffer.begin(), buffer.begin() + count);
    if (count <= 0 && (poll_fd.revents & POLLHUP) != 0) {  // nobody holds the other end now
      hal::RealClock().sleep_until(std::min(end_ns, clock_.now() + 1'000'000));
    }
  }
  return true;
}

template <typename Wanted>
hal::TimeNs CommandTap::wait_for(hal::TimeNs timeout_ns, Wanted&& wanted) {
  const hal::TimeNs end_ns = clock_.now() + timeout_ns;
  SentPacket packet;
  while (next(packet, end_ns - clock_.now())) {
    if (wanted(packet)) return packet.t_ns;
  }
  return 0;
}

hal::TimeNs CommandTap::wait_for_zero(hal::TimeNs timeout_ns) {
  return wait_for(timeout_ns, [](const SentPacket& p) { return p.is_zero_speed(); });
}

hal::TimeNs CommandTap::wait_for_motion(hal::TimeNs timeout_ns) {
  return wait_for(timeout_ns, [](const SentPacket& p) { return p.is_base_control() && !p.is_zero_speed(); });
}

std::vector<SentPacket> CommandTap::listen(hal::TimeNs for_ns) {
  const hal::TimeNs end_ns = clock_.now() + for_ns;
  std::vector<SentPacket> packets;
  SentPacket packet;
  while (next(packet, end_ns - clock_.now())) packets.push_back(packet);
  return packets;
}

void CommandTap::drain() {
  SentPacket packet;
  while (next(packet, 0)) {
  }
  std::array<std::uint8_t, 512> buffer;
  while (::read(fd_, buffer.data(), buffer.size()) > 0) {
  }
  pending_.clear();
}

}  // namespace g3d::test
