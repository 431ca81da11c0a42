// SPDX-License-Identifier: Apache-2.0
// Every field of a Board by table and key, with unit, allowed range and meaning: one list for reading, checking and
// printing.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "board/board.hpp"

namespace g3d::board {

inline constexpr std::size_t kMaxNameBytes = 64;
/// Paths, and lists of addresses.
inline constexpr std::size_t kMaxLongTextBytes = 1024;

struct BoardField {
  std::string_view table;  ///< empty: top level
  std::string_view key;
  std::variant<double Board::*, int Board::*, std::string Board::*> member;
  double low = 0.0;  ///< of numbers, inclusive
  double high = 0.0;
  std::string_view unit;
  std::string_view meaning;
  std::vector<std::string_view> choices;   ///< of texts; empty: any of at most most_bytes
  std::size_t most_bytes = kMaxNameBytes;  ///< of texts
};

[[nodiscard]] std::span<const BoardField> board_fields();
/// "0.002 to 1 m" or "static, dynamic"
[[nodiscard]] std::string allowed_text(const BoardField& field);

}  // namespace g3d::board
