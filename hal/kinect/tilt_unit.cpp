// SPDX-License-Identifier: Apache-2.0
#include "hal/kinect/tilt_unit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace g3d::hal::kinect {
namespace {

constexpr std::uint8_t kSetTilt = 0x31, kSetLight = 0x06, kGetState = 0x32;
constexpr std::size_t kStateBytes = 10;
constexpr double kCountsPerG = 819.0;  // of its accelerometer, a KXSD9 at +-2 g and 12 bits
constexpr int kMostCounts = 2100;      // 2.56 g
constexpr int kUnknownTilt = -128;
constexpr double kMostReported_deg = 45.0;
constexpr std::uint8_t kStopped = 0, kAtStop = 1, kMoving = 4;

Error silent(std::string_view what) {
  return {Reason::io_error, fmt::format("the Kinect's foot does not {}; is its own power supply plugged in?", what)};
}

}  // namespace

Result<TiltState> parse_tilt_state(std::span<const std::uint8_t> answer) {
  if (answer.size() != kStateBytes) {
    return Error{Reason::truncated, fmt::format("the Kinect's foot sent {} bytes of state, not ten", answer.size())};
  }
  const auto malformed = [](std::string_view what) {
    return Error{Reason::malformed, fmt::format("the Kinect's foot sent a state that cannot be: {}", what)};
  };
  TiltState state;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto counts = static_cast<std::int16_t>(answer[2 + 2 * i] << 8 | answer[3 + 2 * i]);
    if (std::abs(counts) > kMostCounts) return malformed("an acceleration of more than 2 g");
    state.acceleration_g[i] = counts / kCountsPerG;
  }
  const auto half_degrees = static_cast<std::int8_t>(answer[8]);
  state.knows_tilt = half_degrees != kUnknownTilt;
  state.tilt_deg = state.knows_tilt ? half_degrees / 2.0 : 0.0;
  if (std::abs(state.tilt_deg) > kMostReported_deg) return malformed("a tilt beyond its range");
  if (answer[9] != kStopped && answer[9] != kAtStop && answer[9] != kMoving) return malformed("an unknown motion");
  state.is_moving = answer[9] == kMoving;
  state.is_at_stop = answer[9] == kAtStop;
  return state;
}

Result<void> TiltUnit::tilt_to(double degrees) {
  if (!(std::abs(degrees) <= kMostTilt_deg)) {
    return Error{Reason::out_of_range, fmt::format("a tilt of {} degrees; +-{} are possible", degrees, kMostTilt_deg)};
  }
  const auto half_degrees = static_cast<std::int16_t>(std::lround(2.0 * degrees));
  if (!usb_->write(kSetTilt, static_cast<std::uint16_t>(half_degrees))) return silent("tilt");
  return {};
}

Result<void> TiltUnit::show(Light light) {
  if (!usb_->write(kSetLight, static_cast<std::uint16_t>(light))) return silent("switch its light");
  return {};
}

Result<TiltState> TiltUnit::state() {
  std::array<std::uint8_t, kStateBytes> answer{};
  const int bytes = usb_->read(kGetState, answer);
  if (bytes < 0) return silent("say how it stands");
  return parse_tilt_state(std::span(answer).first(std::min(static_cast<std::size_t>(bytes), answer.size())));
}

}  // namespace g3d::hal::kinect
