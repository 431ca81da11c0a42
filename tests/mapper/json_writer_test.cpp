// SPDX-License-Identifier: Apache-2.0
#include "mapper/json_writer.hpp"

#include <catch2/catch.hpp>
#include <limits>

using g3d::mapper::json_quoted;
using g3d::mapper::JsonWriter;

TEST_CASE("objects and arrays nest, commas stand between members only", "[mapper][json]") {
  JsonWriter json;
  json.begin_object().member("a", 1).key("b").begin_array().value(true).value("x").end_array();
  json.key("empty").begin_object().end_object().end_object();
  CHECK(json.take() == "{\n  \"a\": 1,\n  \"b\": [\n    true,\n    \"x\"\n  ],\n  \"empty\": {}\n}\n");
}

TEST_CASE("numbers keep their value and JSON's grammar", "[mapper][json]") {
  JsonWriter json;
  json.begin_array().value(0.05).value(1e300).value(std::numeric_limits<double>::quiet_NaN());
  json.value(-std::numeric_limits<double>::infinity()).value(std::uint64_t{18446744073709551615U});
  json.value(std::int64_t{-9}).end_array();
  CHECK(json.take() == "[\n  0.05,\n  1e+300,\n  null,\n  null,\n  18446744073709551615,\n  -9\n]\n");
}

TEST_CASE("text from outside cannot leave its quotes", "[mapper][json]") {
  CHECK(json_quoted("a\"b\\c") == R"("a\"b\\c")");
  CHECK(json_quoted("line\nand\ttab") == R"("line\nand\ttab")");
  CHECK(json_quoted(std::string_view("\x01\x00\x1f", 3)) == R"("\u0001\u0000\u001f")");
  CHECK(json_quoted("gr\xC3\xBC\xC3\x9F") == "\"gr\xC3\xBC\xC3\x9F\"");
  // A lone lead byte, an overlong slash, a surrogate: not UTF-8.
  CHECK(json_quoted("\xC3") == R"("\ufffd")");
  CHECK(json_quoted("\xC0\xAF") == R"("\ufffd\ufffd")");
  CHECK(json_quoted("\xED\xA0\x80") == R"("\ufffd\ufffd\ufffd")");
}
