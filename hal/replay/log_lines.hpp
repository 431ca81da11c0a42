// SPDX-License-Identifier: Apache-2.0
// The lines of a log that was written until its writer ended, be it by a power cut: one after another, without empty
// ones and comments (#), whatever system ended them; what follows the last newline is a line that was torn.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace g3d::hal {

class LogLines {
 public:
  /// `text` outlives this and what it gives.
  explicit LogLines(std::string_view text) : rest_(text) {}

  /// Without its newline. Nothing: there are no more.
  [[nodiscard]] std::optional<std::string_view> next();
  /// Of the line that was given last, from 1.
  [[nodiscard]] std::size_t number() const { return number_; }
  /// Once there are no more: what belongs to no whole line.
  [[nodiscard]] std::size_t torn_bytes() const { return rest_.size(); }

 private:
  std::string_view rest_;
  std::size_t number_ = 0;
};

}  // namespace g3d::hal
