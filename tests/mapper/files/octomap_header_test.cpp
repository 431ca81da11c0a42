// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/octomap_header.hpp"

#include <catch2/catch.hpp>

using namespace g3d;
using namespace g3d::mapper;

namespace {

hal::Result<OctomapHeader> parse(const std::string& text) {
  return decode_octomap_header(Bytes(text.begin(), text.end()), "t.ot");
}

}  // namespace

TEST_CASE("Both formats and both tree types are told apart") {
  const std::string full = "# Octomap OcTree file\n# a comment\n#\nid ColorOcTree\nsize 17\nres 0.025\ndata\n";
  const auto header = parse(full + "xyz");
  REQUIRE(header.ok());
  CHECK_FALSE(header.value().is_binary);
  CHECK(header.value().is_coloured);
  CHECK(header.value().nodes == 17);
  CHECK(header.value().resolution_m == 0.025);
  CHECK(header.value().data_offset == full.size());
  const auto binary = parse("# Octomap OcTree binary file\r\nid OcTree\r\nres 1e-1\r\nsize 0\r\ndata\r\n");
  REQUIRE(binary.ok());
  CHECK(binary.value().is_binary);
  CHECK_FALSE(binary.value().is_coloured);
  CHECK(binary.value().resolution_m == 0.1);
}

TEST_CASE("Errors name the line") {
  const auto text_of = [](const std::string& text) { return parse(text).error().text; };
  CHECK(text_of("ply\n").find("t.ot:1: ") == 0);
  CHECK(text_of("# Octomap OcTree file\nid OcTree\nsize x\n").find("t.ot:3: ") == 0);
  CHECK(text_of("# Octomap OcTree file\nid Tree\n").find("t.ot:2: ") == 0);
  CHECK(text_of("# Octomap OcTree file\ncolour yes\n").find("t.ot:2: an unknown word") == 0);
  CHECK(text_of("# Octomap OcTree file\nid OcTree\n").find("t.ot:3: ") == 0);
}

TEST_CASE("Endless headers are cut short") {
  std::string comments = "# Octomap OcTree file\n";
  for (int i = 0; i < 2000; ++i) comments += "#\n";
  CHECK(parse(comments + "data\n").error().reason == hal::Reason::too_large);
  CHECK_FALSE(parse("# Octomap OcTree file\n" + std::string(1 << 20, '#')).ok());
}
