// SPDX-License-Identifier: Apache-2.0
// The emergency-stop switch and the status lamp at GPIO lines, as a SafetyDevice.
#pragma once

#include <array>
#include <string>

#include "hal/gpio/estop_switch.hpp"

namespace g3d::hal {

class TextRecorder;

struct GpioSafetyOptions {
  bool has_estop = true;
  EstopSwitchOptions estop;  ///< its lines are the inputs
  /// What the recording calls the inputs.
  std::array<std::string, kMaxGpioInputs> names;
};

class GpioSafety final : public SafetyDevice {
 public:
  /// `lines` outlives this; `recorder` too, and may be null.
  GpioSafety(GpioLines& lines, const GpioSafetyOptions& options, TextRecorder* recorder = nullptr);

  [[nodiscard]] StopWord look(TimeNs now_ns) override;
  void show(const SafetyNews& news, TimeNs now_ns) override;
  void say_farewell(TimeNs now_ns) override;

  // The same thread, or after it has ended
  [[nodiscard]] const EstopSwitch& estop() const { return estop_; }
  [[nodiscard]] const GpioLines& lines() const { return lines_; }

 private:
  void record(std::size_t input, bool level, TimeNs t_ns);

  GpioLines& lines_;
  const GpioSafetyOptions options_;
  TextRecorder* const recorder_;
  EstopSwitch estop_;
  std::array<std::optional<bool>, kMaxGpioInputs> recorded_;
  TimeNs last_recorded_ns_ = 0;
  std::optional<bool> lit_;
};

}  // namespace g3d::hal
