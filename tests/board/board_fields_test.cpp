// SPDX-License-Identifier: Apache-2.0
#include "board/board_fields.hpp"

#include <catch2/catch.hpp>
#include <set>
#include <string>

using namespace g3d::board;

TEST_CASE("every default lies within its range") {
  const Board board;
  for (const BoardField& field : board_fields()) {
    CAPTURE(field.table, field.key);
    if (const auto* member = std::get_if<double Board::*>(&field.member)) {
      CHECK(board.**member >= field.low);
      CHECK(board.**member <= field.high);
    } else if (const auto* whole = std::get_if<int Board::*>(&field.member)) {
      CHECK(board.**whole >= field.low);
      CHECK(board.**whole <= field.high);
    } else if (!field.choices.empty()) {
      const std::string& text = board.**std::get_if<std::string Board::*>(&field.member);
      CHECK(std::count(field.choices.begin(), field.choices.end(), text) == 1);
    }
  }
}

TEST_CASE("no key stands twice and tables stand together") {
  std::set<std::string> names;
  std::set<std::string_view> closed_tables;
  std::string_view table;
  for (const BoardField& field : board_fields()) {
    CHECK(names.insert(std::string(field.table) + "." + std::string(field.key)).second);
    if (field.table != table) {
      CHECK(closed_tables.insert(table).second);
      table = field.table;
    }
  }
  CHECK(names.size() == 67);
}

TEST_CASE("what is allowed is said with its unit") {
  for (const BoardField& field : board_fields()) {
    if (field.key == "resolution_m") CHECK(allowed_text(field) == "0.002 to 1 m");
    if (field.key == "mode") CHECK(allowed_text(field) == "static, dynamic");
    if (field.key == "threads") CHECK(allowed_text(field) == "1 to 64");
    if (field.key == "name") CHECK(allowed_text(field) == "a text of 1 to 64 printable bytes");
    if (field.key == "peers") CHECK(allowed_text(field) == "a text of 1 to 1024 printable bytes");
  }
}
