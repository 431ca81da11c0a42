// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/fault_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

#include "hal/replay/decimal.hpp"

namespace g3d::hal {
namespace {

constexpr std::array<const char*, static_cast<std::size_t>(FaultPart::count_)> kParts{"camera", "odometry", "line",
                                                                                      "disk"};
constexpr std::array<const char*, static_cast<std::size_t>(FaultKind::count_)> kKinds{
    "none", "off", "stuck", "garbage", "wrong", "slow", "delayed", "intermittent"};
constexpr double kLatest_s = 1e6;

template <typename Names>
std::optional<std::size_t> index_of(const Names& names, std::string_view name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return static_cast<std::size_t>(found - names.begin());
}

std::optional<TimeNs> parse_time(std::string_view text) {
  const auto seconds = parse_double(text);
  if (!seconds || !(*seconds >= 0.0 && *seconds <= kLatest_s)) return std::nullopt;
  return static_cast<TimeNs>(*seconds * 1e9);
}

}  // namespace

const char* to_string(FaultPart part) {
  return part < FaultPart::count_ ? kParts[static_cast<std::size_t>(part)] : "unknown";
}

const char* to_string(FaultKind kind) {
  return kind < FaultKind::count_ ? kKinds[static_cast<std::size_t>(kind)] : "unknown";
}

Result<PlannedFault> parse_fault(std::string_view text) {
  const Error wrong{Reason::bad_usage,
                    fmt::format("'{}' is no fault: PART:KIND@FROM+SECONDS with camera, odometry, line or disk as PART, "
                                "off, stuck, garbage, wrong, slow, delayed or intermittent as KIND, such as "
                                "camera:stuck@20+5",
                                text.substr(0, 80))};
  const std::size_t at = std::min(text.find('@'), text.size());
  const std::size_t colon = text.substr(0, at).find(':');
  if (colon == std::string_view::npos) return wrong;
  const auto part = index_of(kParts, text.substr(0, colon));
  const auto kind = index_of(kKinds, text.substr(colon + 1, at - colon - 1));
  if (!part || !kind || *kind == 0) return wrong;
  PlannedFault fault;
  fault.part = static_cast<FaultPart>(*part);
  fault.kind = static_cast<FaultKind>(*kind);
  if (at == text.size()) return fault;
  const std::string_view times = text.substr(at + 1);
  const std::size_t plus = times.find('+');
  const auto from_ns = parse_time(times.substr(0, plus));
  if (!from_ns) return wrong;
  fault.from_ns = *from_ns;
  if (plus == std::string_view::npos) return fault;
  const auto duration_ns = parse_time(times.substr(plus + 1));
  if (!duration_ns || *duration_ns == 0) return wrong;
  fault.to_ns = fault.from_ns + *duration_ns;
  return fault;
}

FaultNow fault_at(const FaultPlan& plan, FaultPart part, TimeNs now_ns) {
  FaultNow now;
  for (const PlannedFault& fault : plan) {
    if (fault.part != part || now_ns < fault.from_ns || now_ns >= fault.to_ns) continue;
    now = {fault.kind, now_ns - fault.from_ns};
  }
  return now;
}

bool has_fault_of(const FaultPlan& plan, FaultPart part) {
  return std::any_of(plan.begin(), plan.end(), [&](const PlannedFault& fault) { return fault.part == part; });
}

}  // namespace g3d::hal
