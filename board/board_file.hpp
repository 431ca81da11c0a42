// SPDX-License-Identifier: Apache-2.0
// Board files: TOML with the tables and keys of board_fields.cpp. What a file leaves out keeps its default; an unknown
// key, a wrong type or a number out of range is an error that names file, line and what is allowed.
#pragma once

#include <string>
#include <string_view>

#include "board/board.hpp"
#include "hal/result.hpp"

namespace g3d::board {

/// `file` is what errors call the text.
[[nodiscard]] hal::Result<Board> parse_board(std::string_view text, std::string_view file);
[[nodiscard]] hal::Result<Board> load_board(const std::string& path);

/// The whole board as a board file, every value with unit, range and meaning behind it: printed at start, and readable
/// by parse_board to the same board.
[[nodiscard]] std::string to_text(const Board& board);

}  // namespace g3d::board
