// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/base_trouble.hpp"

namespace g3d::hal {
namespace {

constexpr TimeNs kLate_ns = 150 * kMillisecond_ns;
constexpr double kGarbled = 0.1, kNoisy = 0.001, kLossy = 0.0005;

bool now_and_then(TimeNs since_ns, TimeNs on_ns, TimeNs period_ns) { return since_ns % period_ns < on_ns; }

void spoil_odometry(const FaultNow& now, BaseTrouble& trouble) {
  KobukiFaults& faults = trouble.faults;
  switch (now.kind) {
    case FaultKind::off:
      faults.left_dead = faults.right_dead = true;
      return;
    case FaultKind::stuck:
      faults.stuck = true;
      return;
    case FaultKind::garbage:
      faults.scrambled = true;
      return;
    case FaultKind::wrong:
      faults.left_dead = true;
      return;
    case FaultKind::slow:
      faults.keep_every = 10;
      return;
    case FaultKind::delayed:
      trouble.to_host.latency_ns = kLate_ns;
      return;
    case FaultKind::intermittent:
      faults.left_dead = faults.right_dead =
          now_and_then(now.since_ns, 1'000 * kMillisecond_ns, 2'000 * kMillisecond_ns);
      return;
    case FaultKind::none:
    case FaultKind::count_:
      return;
  }
}

void spoil_line(const FaultNow& now, BaseTrouble& trouble) {
  switch (now.kind) {
    case FaultKind::off:
      trouble.faults.unplugged = true;
      return;
    case FaultKind::stuck:
      trouble.faults.silent = true;
      return;
    case FaultKind::garbage:
      trouble.to_host.corrupt = trouble.to_base.corrupt = kGarbled;
      return;
    case FaultKind::wrong:
      trouble.to_host.corrupt = trouble.to_base.corrupt = kNoisy;
      trouble.to_host.lose = trouble.to_base.lose = kLossy;
      return;
    case FaultKind::slow:
      trouble.faults.keep_every = 5;
      return;
    case FaultKind::delayed:
      trouble.to_host.latency_ns = trouble.to_base.latency_ns = kLate_ns;
      return;
    case FaultKind::intermittent:
      trouble.faults.unplugged = now_and_then(now.since_ns, 300 * kMillisecond_ns, 1'000 * kMillisecond_ns);
      return;
    case FaultKind::none:
    case FaultKind::count_:
      return;
  }
}

}  // namespace

BaseTrouble base_trouble_at(const FaultPlan& plan, TimeNs now_ns, const SimKobukiOptions& usual) {
  BaseTrouble trouble{{}, usual.to_host, usual.to_base};
  spoil_odometry(fault_at(plan, FaultPart::odometry, now_ns), trouble);
  spoil_line(fault_at(plan, FaultPart::line, now_ns), trouble);
  return trouble;
}

}  // namespace g3d::hal
