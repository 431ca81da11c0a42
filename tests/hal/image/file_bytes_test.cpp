// SPDX-License-Identifier: Apache-2.0
#include "hal/image/file_bytes.hpp"

#include <sys/stat.h>

#include <catch2/catch.hpp>

#include "tests/support/temp_folder.hpp"

using namespace g3d::hal;
using g3d::test::TempFolder;
using g3d::test::write_plain;

TEST_CASE("A file is read back as written, and the buffer is reused") {
  const TempFolder folder;
  const std::string path = folder / "a.bin";
  const std::vector<std::uint8_t> content{0, 255, 10, 13, 0};
  REQUIRE(write_file_atomic(path, content).ok());
  CHECK(read_file(path, 5).value() == content);
  CHECK(read_text_file(path, 100).value() == std::string("\0\xff\n\r\0", 5));
  CHECK(folder.listing() == "a.bin\n");

  std::vector<std::uint8_t> bytes(1000);
  const std::uint8_t* const storage = bytes.data();
  REQUIRE(read_file_into(path, 100, bytes).ok());
  CHECK(bytes == content);
  CHECK(bytes.data() == storage);
}

TEST_CASE("Reading refuses what is missing, too large or no file") {
  const TempFolder folder;
  const std::string path = folder / "a.bin";
  write_plain(path, "12345");
  std::vector<std::uint8_t> bytes{1};
  const Result<void> too_large = read_file_into(path, 4, bytes);
  REQUIRE_FALSE(too_large.ok());
  CHECK(too_large.error().reason == Reason::too_large);
  CHECK(bytes.empty());
  CHECK(read_file(folder / "none", 10).error().reason == Reason::not_found);
  CHECK(read_file(folder.path(), 10).error().reason == Reason::unsupported);
  const std::string pipe = folder / "pipe";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  CHECK(read_file(pipe, 10).error().reason == Reason::unsupported);
  CHECK(read_file(folder / "none", 10).error().text.find("none") != std::string::npos);
}
