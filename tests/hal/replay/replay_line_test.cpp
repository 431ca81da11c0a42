// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/replay_line.hpp"

#include <catch2/catch.hpp>

namespace {

using namespace g3d::hal;
using Bytes = std::vector<std::uint8_t>;

KobukiLog three_records() {
  Bytes file;
  append_record(file, 100, Bytes{1, 2, 3});
  append_record(file, 100, Bytes{4});
  append_record(file, 200, Bytes{5, 6});
  return std::move(KobukiLog::parse(file, "kobuki.bin")).value();
}

Bytes read_some(ReplayLine& line, std::size_t max_bytes) {
  Bytes bytes(max_bytes);
  bytes.resize(line.read(bytes));
  return bytes;
}

TEST_CASE("recorded bytes come at their time") {
  const KobukiLog log = three_records();
  DataClock clock;
  ReplayLine line(log, clock);
  CHECK(line.next_ns() == 100);
  CHECK(read_some(line, 10).empty());
  clock.advance_to(100);
  CHECK(read_some(line, 2) == Bytes{1, 2});
  CHECK(line.next_ns() == 100);
  CHECK(read_some(line, 10) == Bytes{3, 4});
  CHECK(read_some(line, 10).empty());
  CHECK(line.next_ns() == 200);
  CHECK(line.state() == LineState::up);
  clock.advance_to(1000);
  CHECK(read_some(line, 10) == Bytes{5, 6});
  CHECK(line.state() == LineState::lost);
  CHECK_FALSE(line.next_ns());
  CHECK(read_some(line, 10).empty());
}

TEST_CASE("what is written goes nowhere, until the recording ends") {
  const KobukiLog log = three_records();
  DataClock clock;
  ReplayLine line(log, clock);
  CHECK(line.write(Bytes(10)));
  CHECK(line.swallowed_bytes() == 10);
  clock.advance_to(200);
  (void)read_some(line, 10);
  CHECK_FALSE(line.write(Bytes(10)));
  CHECK(line.swallowed_bytes() == 10);
}

}  // namespace
