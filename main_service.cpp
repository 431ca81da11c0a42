// SPDX-License-Identifier: Apache-2.0
#include "main_service.hpp"

#include <fmt/format.h>

#include <array>
#include <iterator>

#include "nav/mission.hpp"

namespace g3d {
namespace {

constexpr hal::TimeNs kStatusPeriod_ns = 2'000 * hal::kMillisecond_ns;
/// For files on a disk that may be slow; the unit's TimeoutStopSec is the same.
constexpr hal::TimeNs kSaving_ns = 90'000 * hal::kMillisecond_ns;

}  // namespace

void ServiceReport::look(hal::TimeNs now_ns, std::uint64_t integrated, const nav::LiveStatus& status) {
  if (!notify_.is_supervised()) return;
  if (!is_ready_ && integrated > 0) is_ready_ = notify_.ready();
  if (now_ns < next_status_ns_) return;
  next_status_ns_ = now_ns + kStatusPeriod_ns;
  std::array<char, hal::ServiceNotify::kMostStatus_bytes> text;
  const auto end =
      fmt::format_to_n(text.data(), text.size(), "{}, {} frames mapped, {:.1f} m driven, battery {:.1f} V{}{}",
                       nav::name_of(status.state), integrated, status.path_m, status.battery_v,
                       status.limited_by == hal::Condition::count_ ? "" : ", held back by ",
                       status.limited_by == hal::Condition::count_ ? "" : hal::to_string(status.limited_by));
  (void)notify_.status({text.data(), static_cast<std::size_t>(std::distance(text.data(), end.out))});
}

void ServiceReport::stopping() {
  if (!notify_.is_supervised()) return;
  (void)notify_.status("stands, writes its map");
  (void)notify_.allow_silence(kSaving_ns);
  (void)notify_.stopping();
}

}  // namespace g3d
