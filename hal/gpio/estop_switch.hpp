// SPDX-License-Identifier: Apache-2.0
// An emergency-stop switch at one or two lines: debounced, and such that a broken wire is a stop. Pure: levels and
// stamps in, word out.
//
// The contact is normally closed: while it is closed its line has the level `closed_level`, so a cut wire, a pulled
// plug and a pressed switch look the same. Two lines are the two contacts of one switch; `second_is_opposite`: of which
// one opens while the other closes, so that a short circuit between wires shows as well. As long as both do not say go
// it is a stop; if they do not agree for longer than contacts of one switch take, it is a fault.
#pragma once

#include <array>

#include "hal/gpio/gpio_lines.hpp"
#include "hal/safety_device.hpp"

namespace g3d::hal {

struct EstopSwitchOptions {
  std::size_t lines = 1;
  bool closed_level = true;             ///< of the first line
  bool second_is_opposite = true;       ///< the second line's closed level is the other one
  TimeNs glitch_ns = 1'000'000;         ///< an opening that is over sooner is a disturbance, counted; 0: there are none
  TimeNs settle_ns = 50'000'000;        ///< closed for so long without bouncing, before it counts as released
  TimeNs discrepancy_ns = 100'000'000;  ///< for so long two lines may disagree
};

enum class EstopFault : std::uint8_t { none, unreadable, discrepancy };
[[nodiscard]] const char* to_string(EstopFault fault);

class EstopSwitch {
 public:
  explicit EstopSwitch(const EstopSwitchOptions& options) : options_(options) {}

  /// Edges in the order in which they came.
  void on_edge(const GpioEdge& edge);
  /// What the line says now, which edges that got lost would have told.
  void on_level(std::size_t line, bool level, TimeNs now_ns);
  /// A line that cannot be read is open.
  void on_unreadable(std::size_t line, TimeNs now_ns);
  /// `not_yet` until all lines have been seen closed for settle_ns; pressed at the start, too, it is a stop.
  [[nodiscard]] StopWord word(TimeNs now_ns);

  [[nodiscard]] EstopFault fault() const { return fault_; }
  [[nodiscard]] std::uint64_t presses() const { return presses_; }
  [[nodiscard]] std::uint64_t glitches() const { return glitches_; }

 private:
  struct Line {
    bool was_seen = false;
    bool is_closed = false;
    bool is_unreadable = false;
    bool opened_for_long = false;  ///< since the last word(): an opening that was no glitch
    TimeNs since_ns = 0;           ///< of its present state
  };
  [[nodiscard]] bool closed_level(std::size_t line) const {
    return line == 1 && options_.second_is_opposite ? !options_.closed_level : options_.closed_level;
  }
  void set(std::size_t line, bool is_closed, TimeNs t_ns);

  const EstopSwitchOptions options_;
  std::array<Line, kMaxGpioInputs> lines_{};
  bool was_released_ = false;
  bool is_stopped_ = false;
  bool disagrees_ = false;
  TimeNs disagrees_since_ns_ = 0;
  EstopFault fault_ = EstopFault::none;
  std::uint64_t presses_ = 0, glitches_ = 0;
};

}  // namespace g3d::hal
