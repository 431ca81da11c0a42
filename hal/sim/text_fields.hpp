// SPDX-License-Identifier: Apache-2.0
// Line by line, word by word through a text file from outside: `#` begins a comment, words are parted by blanks, every
// complaint names file and line. Shared by the readers of world files and camera paths.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/result.hpp"

namespace g3d::hal {

/// Longest text that is read as a world file or a camera path.
inline constexpr std::size_t kMaxTextBytes = std::size_t{4} << 20;

/// The words of one line. Views into the text that was given.
class TextLine {
 public:
  TextLine(std::string_view file, std::size_t number, std::vector<std::string_view> words)
      : file_(file), number_(number), words_(std::move(words)) {}

  [[nodiscard]] const std::vector<std::string_view>& words() const { return words_; }
  [[nodiscard]] std::size_t number() const { return number_; }
  /// Error that begins with FILE:LINE.
  [[nodiscard]] Error error(Reason reason, std::string_view what) const;
  /// A finite number within [low, high]; `name` says in the error what it stands for.
  [[nodiscard]] Result<double> number_in(std::string_view word, std::string_view name, double low, double high) const;

 private:
  std::string_view file_;
  std::size_t number_;
  std::vector<std::string_view> words_;
};

/// All lines that hold at least one word. Refuses text over kMaxTextBytes and lines with control characters.
[[nodiscard]] Result<std::vector<TextLine>> split_lines(std::string_view text, std::string_view file);

/// A decimal number that fills the whole word and is finite.
[[nodiscard]] std::optional<double> parse_number(std::string_view word);

}  // namespace g3d::hal
