// SPDX-License-Identifier: Apache-2.0
#include "net/claim_book.hpp"

#include <catch2/catch.hpp>

using namespace g3d;
using net::ClaimBook;

TEST_CASE("of two who claim one place the lower id has it", "[net][claims]") {
  ClaimBook book;
  book.note({5, {1.0, 1.0, 0.0}});
  book.note({3, {1.2, 1.0, 2.0}});
  book.note({9, {4.0, 1.0, 0.0}});
  book.settle(0.75);
  CHECK(book.stands(3));
  CHECK_FALSE(book.stands(5));
  CHECK(book.stands(9));
  CHECK_FALSE(book.stands(4));
}

TEST_CASE("a claim that does not stand is in nobody's way", "[net][claims]") {
  ClaimBook book;
  // 2 is near to 1, and 3 near to 2 alone.
  book.note({1, {0.0, 0.0, 0.0}});
  book.note({2, {0.5, 0.0, 0.0}});
  book.note({3, {1.0, 0.0, 0.0}});
  book.settle(0.75);
  CHECK(book.stands(1));
  CHECK_FALSE(book.stands(2));
  CHECK(book.stands(3));
  // Who is not heard of any more claims nothing.
  book.clear();
  book.note({2, {0.5, 0.0, 0.0}});
  book.settle(0.75);
  CHECK(book.stands(2));
  CHECK_FALSE(book.stands(1));
}

TEST_CASE("more claims than there is room for are left out", "[net][claims]") {
  ClaimBook book;
  for (net::RobotId robot = 1; robot <= 200; ++robot) book.note({robot, {10.0 * static_cast<double>(robot), 0, 0}});
  book.settle(0.75);
  CHECK(book.all().size() == net::kMostHeard + 1);
  CHECK(book.stands(1));
  CHECK_FALSE(book.stands(200));
}
