// SPDX-License-Identifier: Apache-2.0
// When the robot's process is started again after it has ended, and when starting again is no use. Plain; one thread.
#pragma once

#include <cstdint>

#include "hal/boot/init_config.hpp"
#include "hal/messages.hpp"

namespace g3d::hal::boot {

/// How a process has ended.
struct ProcessEnd {
  int exit_code = 0;  ///< if no signal killed it
  int signal = 0;     ///< that killed it; 0: none
  [[nodiscard]] bool is_good() const { return signal == 0 && exit_code == 0; }
};

enum class NextStep : std::uint8_t {
  start_again,  ///< after wait_ns
  stay,         ///< it has done its work
  power_off,    ///< it has done its work
  reboot,       ///< a system on trial that does not run: the next start counts against it
};

class RestartPolicy {
 public:
  struct Decision {
    NextStep step = NextStep::start_again;
    TimeNs wait_ns = 0;
  };
  static constexpr TimeNs kFirstWait_ns = 500'000'000;
  static constexpr TimeNs kLongestWait_ns = 30'000'000'000;
  /// After so long without an end the next one is the first again.
  static constexpr TimeNs kForget_ns = 60'000'000'000;
  /// A system on trial that ends so often goes back.
  static constexpr int kMostEndsOnTrial = 3;

  explicit RestartPolicy(WhenDone when_done) : when_done_(when_done) {}

  /// `ran_ns`: from its start to its end. `is_on_trial`: a system that has not proved itself yet.
  [[nodiscard]] Decision on_end(const ProcessEnd& end, TimeNs ran_ns, bool is_on_trial);
  /// Bad ends since it last ran for long.
  [[nodiscard]] int ends() const { return ends_; }

 private:
  WhenDone when_done_;
  int ends_ = 0;
};

}  // namespace g3d::hal::boot
