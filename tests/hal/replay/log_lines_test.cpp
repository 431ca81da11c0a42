// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/log_lines.hpp"

#include <catch2/catch.hpp>

using g3d::hal::LogLines;

TEST_CASE("lines of a log are given with their numbers, comments and empty ones are not") {
  LogLines lines("# begun\n\nfirst\r\n\r\nsecond # not a comment\n#\ntorn");
  CHECK(lines.next() == "first");
  CHECK(lines.number() == 3);
  CHECK(lines.next() == "second # not a comment");
  CHECK(lines.number() == 5);
  CHECK_FALSE(lines.next());
  CHECK(lines.torn_bytes() == 4);
  CHECK_FALSE(lines.next());
}

TEST_CASE("a log without a line has none, torn or not") {
  LogLines empty("");
  CHECK_FALSE(empty.next());
  CHECK(empty.torn_bytes() == 0);
  LogLines whole("one\n");
  CHECK(whole.next() == "one");
  CHECK_FALSE(whole.next());
  CHECK(whole.torn_bytes() == 0);
}
