// SPDX-License-Identifier: Apache-2.0
#include "hal/image/pgm.hpp"

#include <catch2/catch.hpp>

#include "tests/support/temp_folder.hpp"

using namespace g3d::hal;

namespace {

std::vector<std::uint8_t> bytes_of(std::string_view text) { return {text.begin(), text.end()}; }

Reason error_of(std::string_view text) {
  const Result<GreyImage> parsed = parse_pgm(bytes_of(text), "m.pgm");
  REQUIRE_FALSE(parsed.ok());
  CHECK(parsed.error().text.find("m.pgm: byte ") == 0);
  return parsed.error().reason;
}

}  // namespace

TEST_CASE("A PGM survives the way through a file, with its comment") {
  const g3d::test::TempFolder folder;
  const std::string path = folder / "m.pgm";
  const GreyImage image{{3, 2}, 255, {0, 205, 254, 10, 13, 35}};
  REQUIRE(write_pgm(path, image, "CREATOR: a test, 0.05 m/pix").ok());
  const GreyImage back = read_pgm(path).value();
  CHECK(back.size == image.size);
  CHECK(back.max_value == 255);
  CHECK(back.pixels == image.pixels);
  CHECK(g3d::test::read_plain(path).substr(0, 13) == "P5\n# CREATOR:");
  CHECK(read_pgm(folder / "none.pgm").error().reason == Reason::not_found);
}

TEST_CASE("Comments and white space may stand anywhere in the header") {
  const GreyImage image = parse_pgm(bytes_of("P5 # one\r# 9 9\n\t2#three\n\n 1 # four\n 200\nab"), "m.pgm").value();
  CHECK(image.size == ImageSize{2, 1});
  CHECK(image.max_value == 200);
  CHECK(image.pixels == bytes_of("ab"));
  // Exactly one white space ends the header, even if the first pixel looks like another.
  CHECK(parse_pgm(bytes_of("P5 2 1 255\n\n#"), "m.pgm").value().pixels == bytes_of("\n#"));
}

TEST_CASE("Broken and lying PGMs are refused with the byte") {
  CHECK(error_of("") == Reason::unsupported);
  CHECK(error_of("P2 1 1 255 0") == Reason::unsupported);
  CHECK(error_of("P5") == Reason::truncated);
  CHECK(error_of("P5 2 # never ends") == Reason::truncated);
  CHECK(error_of("P5 2 x 255\nab") == Reason::malformed);
  CHECK(error_of("P5 -2 1 255\nab") == Reason::malformed);
  CHECK(error_of("P5 0 1 255\n") == Reason::out_of_range);
  CHECK(error_of("P5 99999999999999999999 1 255\na") == Reason::too_large);
  CHECK(error_of("P5 16384 16384 255\na") == Reason::truncated);
  CHECK(error_of("P5 1 1 65535\nab") == Reason::too_large);
  CHECK(error_of("P5 1 1 0\na") == Reason::out_of_range);
  CHECK(error_of("P5 1 1 255xa") == Reason::malformed);
  CHECK(error_of("P5 2 1 255\na") == Reason::truncated);
  CHECK(error_of("P5 2 1 96\naa") == Reason::out_of_range);
}

TEST_CASE("Impossible images are not written") {
  CHECK(encode_pgm({{2, 1}, 255, {1}}, "").error().reason == Reason::bad_usage);
  CHECK(encode_pgm({{0, 1}, 255, {}}, "").error().reason == Reason::bad_usage);
  CHECK(encode_pgm({{1, 1}, 255, {1}}, "two\nlines").error().reason == Reason::bad_usage);
  CHECK(encode_pgm({{1, 1}, 255, {1}}, "").ok());
}
