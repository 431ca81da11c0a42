// SPDX-License-Identifier: Apache-2.0
#include "board/board_file.hpp"

#include <fmt/format.h>

#include <algorithm>

// Version 3.3 asserts that a key begins well ("[.a" does not) just before it checks the same and reports an error.
#define TOML_ASSERT(condition) static_assert(true)
#define TOML_EXCEPTIONS 0
#include <toml++/toml.h>

#include "board/board_fields.hpp"
#include "hal/image/file_bytes.hpp"

namespace g3d::board {
namespace {

using hal::Error;
using hal::Reason;
using hal::Result;

constexpr std::size_t kMaxBoardBytes = 256U << 10;

std::string full_name(std::string_view table, std::string_view key) {
  return table.empty() ? std::string(key) : fmt::format("{}.{}", table, key);
}

Error error_at(std::string_view file, const toml::source_region& where, Reason reason, std::string_view what) {
  return {reason, fmt::format("{}:{}: {}", file, where.begin.line, what)};
}

bool is_printable(const std::string& text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= 0x20 && c < 0x7F && c != '"' && c != '\\'; });
}

bool is_allowed(const BoardField& field, const std::string& text) {
  if (field.choices.empty()) return !text.empty() && text.size() <= field.most_bytes && is_printable(text);
  // "stream:PLACE" stands for every text that begins with "stream:".
  return std::any_of(field.choices.begin(), field.choices.end(), [&text](std::string_view choice) {
    constexpr std::string_view kOpen = ":PLACE";
    if (!choice.ends_with(kOpen)) return choice == text;
    choice.remove_suffix(kOpen.size() - 1);
    return text.starts_with(choice) && text.size() > choice.size() && is_printable(text);
  });
}

/// Writes one value into the board, if its type and range are right.
Result<void> read_value(const BoardField& field, const toml::node& node, std::string_view file, Board& board) {
  const std::string name = full_name(field.table, field.key);
  const auto wrong_type = [&](std::string_view wanted) {
    return error_at(file, node.source(), Reason::malformed,
                    fmt::format("{} must be {}: {}", name, wanted, allowed_text(field)));
  };
  const auto out_of_range = [&](const auto& value) {
    return error_at(file, node.source(), Reason::out_of_range,
                    fmt::format("{} is {}, allowed are {}", name, value, allowed_text(field)));
  };
  if (const auto* member = std::get_if<std::string Board::*>(&field.member)) {
    const auto text = node.value_exact<std::string>();
    if (!text) return wrong_type("a text in quotes");
    if (!is_allowed(field, *text)) return out_of_range(text->substr(0, kMaxNameBytes));
    board.** member = *text;
    return {};
  }
  if (const auto* member = std::get_if<int Board::*>(&field.member)) {
    const auto whole = node.value_exact<std::int64_t>();
    if (!whole) return wrong_type("a whole number");
    const auto value = static_cast<double>(*whole);
    if (!(value >= field.low && value <= field.high)) return out_of_range(*whole);
    board.** member = static_cast<int>(*whole);
    return {};
  }
  if (!node.is_number()) return wrong_type("a number");
  const double value = node.value<double>().value_or(0.0);
  if (!(value >= field.low && value <= field.high)) return out_of_range(value);  // NaN too
  board.**std::get_if<double Board::*>(&field.member) = value;
  return {};
}

Result<void> read_table(const toml::table& table, std::string_view table_name, std::string_view file, Board& board) {
  for (const auto& [key, node] : table) {
    const std::string_view name = key.str();
    const auto fields = board_fields();
    const auto has_table = [name](const BoardField& f) { return f.table == name; };
    if (const toml::table* inner = node.as_table();
        inner != nullptr && table_name.empty() && std::any_of(fields.begin(), fields.end(), has_table)) {
      if (auto read = read_table(*inner, name, file, board); !read) return read;
      continue;
    }
    const auto field = std::find_if(fields.begin(), fields.end(), [table_name, name](const BoardField& f) {
      return f.table == table_name && f.key == name;
    });
    if (field == fields.end()) {
      std::string known;
      for (const BoardField& f : fields) {
        if (f.table == table_name) known += fmt::format(" {}", f.key);
        if (table_name.empty() && !f.table.empty() && known.find(fmt::format("[{}]", f.table)) == std::string::npos) {
          known += fmt::format(" [{}]", f.table);
        }
      }
      return error_at(file, key.source(), Reason::malformed,
                      fmt::format("{} is not known; here are{}", full_name(table_name, name.substr(0, 40)), known));
    }
    if (auto read = read_value(*field, node, file, board); !read) return read;
  }
  return {};
}

/// Plain ASCII alone, comments too: toml++ 3.3 runs into undefined behaviour on some other characters between words.
Result<void> check_characters(std::string_view text, std::string_view file) {
  std::size_t line = 1;
  for (const char c : text) {
    if (c == '\n') ++line;
    if ((c >= 0x20 && c < 0x7F) || c == '\n' || c == '\r' || c == '\t') continue;
    return Error{Reason::malformed, fmt::format("{}:{}: byte 0x{:02X}; a board file is plain ASCII, its comments too",
                                                file, line, static_cast<unsigned char>(c))};
  }
  return {};
}

/// What no single field's range can say.
Result<void> check_together(const Board& board, std::string_view file) {
  const auto error = [&](std::string_view what) {
    return Error{Reason::out_of_range, fmt::format("{}: {}", file, what)};
  };
  if (board.base_line != "sim" && board.base_line != "auto" && board.base_line != "none" &&
      board.base_line.front() != '/') {
    return error("base.line must be sim, auto, none, or the whole path of a serial port such as /dev/ttyUSB0");
  }
  if (board.map_near_m >= board.map_far_m) return error("map.near_m must be below map.far_m");
  if (board.ground_low_m >= board.ground_high_m) return error("ground.low_m must be below ground.high_m");
  if (board.camera_cx_px >= board.camera_width_px || board.camera_cy_px >= board.camera_height_px) {
    return error("camera.cx_px and camera.cy_px must lie within the image");
  }
  if (board.map_window_radius_m > 0.0 && board.map_window_radius_m < board.map_far_m) {
    return error("map.window_radius_m must be 0 or at least map.far_m, or blocks in view would be paged out");
  }
  return {};
}

}  // namespace

Result<Board> parse_board(std::string_view text, std::string_view file) {
  if (text.size() > kMaxBoardBytes) {
    return Error{Reason::too_large, fmt::format("{}: {} bytes are too many for a board file", file, text.size())};
  }
  if (auto checked = check_characters(text, file); !checked) return checked.error();
  const toml::parse_result parsed = toml::parse(text);
  if (!parsed) {
    return error_at(file, parsed.error().source(), Reason::malformed, parsed.error().description());
  }
  Board board;
  if (auto read = read_table(parsed.table(), "", file, board); !read) return read.error();
  if (auto checked = check_together(board, file); !checked) return checked.error();
  return board;
}

Result<Board> load_board(const std::string& path) {
  const auto text = hal::read_text_file(path, kMaxBoardBytes);
  if (!text) return text.error();
  return parse_board(text.value(), path);
}

std::string to_text(const Board& board) {
  std::string out;
  std::string_view table;
  for (const BoardField& field : board_fields()) {
    if (field.table != table) out += fmt::format("\n[{}]\n", field.table);
    table = field.table;
    std::string value;
    if (const auto* text = std::get_if<std::string Board::*>(&field.member)) {
      value = fmt::format("\"{}\"", board.**text);
    } else if (const auto* whole = std::get_if<int Board::*>(&field.member)) {
      value = fmt::format("{}", board.**whole);
    } else {
      value = fmt::format("{}", board.**std::get_if<double Board::*>(&field.member));
    }
    out += fmt::format("{:<36} # {}{}{}\n", fmt::format("{} = {}", field.key, value), allowed_text(field),
                       field.meaning.empty() ? "" : "; ", field.meaning);
  }
  return out;
}

}  // namespace g3d::board
