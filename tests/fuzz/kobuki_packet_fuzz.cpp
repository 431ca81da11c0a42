// SPDX-License-Identifier: Apache-2.0
// A base's line from hostile hands, for 10^8 inputs: one pass over the bytes, as they are or, if the first byte is odd,
// with the checksum of every frame made right. Whatever comes out lies within the gates and can follow what came
// before, no step of the odometry is longer than they allow, and no safety flag is set for one packet alone.
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "hal/kobuki/odometry.hpp"
#include "hal/kobuki/packet_gates.hpp"
#include "hal/kobuki/packet_reader.hpp"

namespace {

using namespace g3d::hal::kobuki;

/// Six packets: longer inputs tell nothing more.
constexpr std::size_t kMaxInput_bytes = 512;

void check(bool holds) {
  if (!holds) std::abort();
}

void repair(std::span<std::uint8_t> bytes) {
  for (std::size_t at = 0; at + 4 < bytes.size(); ++at) {
    if (bytes[at] != kFrameHeader0 || bytes[at + 1] != kFrameHeader1) continue;
    const std::size_t end = at + 3 + bytes[at + 2];
    if (bytes[at + 2] > kMaxPayload_bytes || end >= bytes.size()) continue;
    std::uint8_t sum = 0;
    for (std::size_t i = at + 2; i < end; ++i) sum ^= bytes[i];
    bytes[end] = sum;
    at = end;
  }
}

std::uint32_t flags_of(const Feedback& f) {
  return static_cast<std::uint32_t>(f.bumper | f.cliff << 8 | f.wheel_drop << 16 | f.over_current << 24);
}

class Checker {
 public:
  void take(const Feedback& feedback, std::uint64_t restarts) {
    check(!impossible_value(feedback));
    check(taken_ == 0 || restarts > restarts_ || !impossible_step(last_, feedback));
    last_ = feedback;
    restarts_ = restarts;
    check(feedback.gyro_sample_count <= feedback.gyro.size());
    const std::uint32_t flags = flags_of(feedback);
    check((last_flags_ & ~flags & ~flags_before_) == 0);  // cleared although set only once
    flags_before_ = last_flags_;
    last_flags_ = flags;
    ++taken_;

    const auto before = odometry_.T_world_base();
    odometry_.update(feedback);
    const auto after = odometry_.T_world_base();
    const double way_m = std::hypot(after.x_m - before.x_m, after.y_m - before.y_m);
    check(way_m <= max_ticks_in(kStampSlack_ms) * kMetresPerTick);
    check(std::abs(after.heading_rad) <= 3.1415926535897936);
  }
  [[nodiscard]] std::uint64_t taken() const { return taken_; }

 private:
  Odometry odometry_;
  Feedback last_;
  std::uint64_t restarts_ = 0;
  std::uint32_t flags_before_ = 0, last_flags_ = 0;
  std::uint64_t taken_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  if (size_bytes < 2 || size_bytes > kMaxInput_bytes) return -1;
  std::array<std::uint8_t, kMaxInput_bytes> copy;
  const std::span<std::uint8_t> bytes(copy.data(), size_bytes - 1);
  std::memcpy(bytes.data(), data + 1, bytes.size());
  if (data[0] % 2 == 1) repair(bytes);

  PacketReader reader;
  Checker checker;
  reader.feed(bytes, 0, [&](const Feedback& feedback) { checker.take(feedback, reader.restarts()); });
  const RejectCounts& rejects = reader.rejects();
  check(checker.taken() <= rejects.accepted_frames && rejects.skipped_bytes <= bytes.size());
  return 0;
}
