// SPDX-License-Identifier: Apache-2.0
// Board files: any bytes give a board or an error; a board prints to a text that reads back to the same board.
#include <cstdlib>
#include <string_view>

#include "board/board_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  using namespace g3d;
  const auto read = board::parse_board({reinterpret_cast<const char*>(data), size_bytes}, "fuzz.toml");
  if (!read) {
    if (read.error().text.find("fuzz.toml") != 0) std::abort();
    return 0;
  }
  const auto again = board::parse_board(board::to_text(read.value()), "again.toml");
  if (!again || !(again.value() == read.value())) std::abort();
  return 0;
}
