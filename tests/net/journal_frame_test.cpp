// SPDX-License-Identifier: Apache-2.0
#include "net/journal_frame.hpp"

#include <catch2/catch.hpp>
#include <vector>

#include "tests/support/temp_folder.hpp"

using namespace g3d;
using mapper::Bytes;
using net::FrameReader;
using Next = FrameReader::Next;

namespace {

Bytes journal_of(const std::vector<Bytes>& frames) {
  Bytes file(net::kJournalMark.begin(), net::kJournalMark.end());
  for (const Bytes& entries : frames) net::add_frame(file, entries);
  return file;
}

/// How many frames can be read, and how many places were damaged.
std::pair<int, int> frames_in(const std::string& path, std::uint64_t& good_bytes) {
  FrameReader reader;
  REQUIRE(reader.open(path).ok());
  std::pair<int, int> found{0, 0};
  for (;;) {
    const Next next = reader.next().value();
    if (next == Next::end) break;
    ++(next == Next::frame ? found.first : found.second);
  }
  good_bytes = reader.good_bytes();
  return found;
}

}  // namespace

TEST_CASE("frames are read as they were written, also those longer than what is read at a time", "[net]") {
  const test::TempFolder folder;
  std::vector<Bytes> frames;
  for (std::size_t i = 0; i < 12; ++i)
    frames.emplace_back(i % 3 == 0 ? net::kMostFrame_bytes : 10 + i, static_cast<std::uint8_t>(i));
  const Bytes file = journal_of(frames);
  test::write_plain(folder / "j", file);
  FrameReader reader;
  REQUIRE(reader.open(folder / "j").ok());
  for (const Bytes& entries : frames) {
    REQUIRE(reader.next().value() == Next::frame);
    REQUIRE(Bytes(reader.entries().begin(), reader.entries().end()) == entries);
  }
  CHECK(reader.next().value() == Next::end);
  CHECK(reader.next().value() == Next::end);
  CHECK(reader.good_bytes() == file.size());
}

TEST_CASE("a journal that ends anywhere has the frames that are whole", "[net]") {
  const test::TempFolder folder;
  const Bytes file = journal_of({Bytes(20, 1), Bytes(5, 2), Bytes(30, 3)});
  const std::size_t ends[] = {16 + 28, 16 + 28 + 13, 16 + 28 + 13 + 38};
  REQUIRE(ends[2] == file.size());
  for (std::size_t size = 0; size <= file.size(); ++size) {
    test::write_plain(folder / "j", mapper::ByteSpan(file).first(size));
    if (size < 16) {
      FrameReader reader;
      CHECK(reader.open(folder / "j").error().reason == hal::Reason::unsupported);
      continue;
    }
    std::uint64_t good_bytes = 0;
    const int whole = size >= ends[2] ? 3 : size >= ends[1] ? 2 : size >= ends[0] ? 1 : 0;
    CHECK(frames_in(folder / "j", good_bytes) == std::pair{whole, 0});
    CHECK(good_bytes == (whole == 0 ? 16 : ends[whole - 1]));
  }
  FrameReader reader;
  CHECK(reader.open(folder / "none").error().reason == hal::Reason::not_found);
}

TEST_CASE("a wrong bit costs its frame, or all from there on where it is in the length", "[net]") {
  const test::TempFolder folder;
  const Bytes file = journal_of({Bytes(20, 1), Bytes(5, 2), Bytes(9, 2), Bytes(30, 3)});
  for (std::size_t at = 16; at < file.size(); ++at) {
    for (const std::uint8_t bit : {1, 16, 128}) {
      Bytes wrong = file;
      wrong[at] ^= bit;
      test::write_plain(folder / "j", wrong);
      std::uint64_t good_bytes = 0;
      const auto [whole, damaged] = frames_in(folder / "j", good_bytes);
      INFO("byte " << at << " bit " << int(bit));
      CHECK(whole <= 3);
      CHECK(damaged <= 1);
      if (damaged == 1) CHECK(good_bytes == file.size());
    }
  }
  // Two neighbours are passed over together.
  Bytes wrong = file;
  wrong[16 + 28 + 9] ^= 1;
  wrong[16 + 28 + 13 + 10] ^= 1;
  test::write_plain(folder / "j", wrong);
  std::uint64_t good_bytes = 0;
  CHECK(frames_in(folder / "j", good_bytes) == std::pair{2, 1});
}
