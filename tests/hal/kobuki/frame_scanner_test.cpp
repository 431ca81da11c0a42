// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/frame_scanner.hpp"

#include <catch2/catch.hpp>
#include <vector>

#include "tests/support/kobuki_packets.hpp"

namespace {

using namespace g3d::hal::kobuki;
using g3d::tests::from_hex;
using Bytes = std::vector<std::uint8_t>;

/// Block 1 has four bytes, all others what they like.
bool block_1_has_4_bytes(std::uint8_t id, std::size_t size_bytes) { return id != 1 || size_bytes == 4; }

struct Scan {
  std::vector<Bytes> payloads;
  RejectCounts rejects;
};

Scan scan(const Bytes& bytes) {
  Scan result;
  FrameScanner scanner(block_1_has_4_bytes);
  for (std::span<const std::uint8_t> rest = bytes; !rest.empty();) {
    rest = rest.subspan(scanner.append(rest));
    for (auto payload = scanner.next(result.rejects); !payload.empty(); payload = scanner.next(result.rejects)) {
      result.payloads.emplace_back(payload.begin(), payload.end());
    }
  }
  return result;
}

const char* const kGood = "aa 55 06 01 04 c8 00 00 00 cb ";

TEST_CASE("a frame is found between any bytes") {
  for (const char* before :
       {"", "00", "aa", "aaaaaa", "aa55", "55", "aa5500", "aa5502", "aa55a1", "aa55ff", "aa55060104"}) {
    Bytes bytes = from_hex(before);
    const Bytes good = from_hex(kGood);
    bytes.insert(bytes.end(), good.begin(), good.end());
    const Scan found = scan(bytes);
    CAPTURE(before);
    REQUIRE(found.payloads.size() == 1);
    CHECK(found.payloads[0] == from_hex("0104c8000000"));
    CHECK(found.rejects.accepted_frames == 1);
    CHECK(found.rejects.skipped_bytes == bytes.size() - good.size());
  }
}

TEST_CASE("what is wrong with a frame is counted") {
  CHECK(scan(from_hex("aa550201040000")).rejects[Reject::bad_length] == 1);
  CHECK(scan(from_hex("aa55a101040000")).rejects[Reject::bad_length] == 1);
  CHECK(scan(from_hex("aa5506010500")).rejects[Reject::wrong_block_size] == 1);
  CHECK(scan(from_hex("aa5506020500")).rejects[Reject::block_overruns] == 1);
  CHECK(scan(from_hex("aa5503020000")).rejects[Reject::block_overruns] == 1);
  CHECK(scan(from_hex("aa55060104c8000000cc")).rejects[Reject::bad_checksum] == 1);
}

TEST_CASE("a frame that is in fact two is given up for the one inside") {
  // The outer header announces 20 bytes: an unknown block that holds a whole good frame, then a wrong checksum.
  Bytes bytes = from_hex("aa 55 14 63 12");
  for (int i = 0; i < 2; ++i) {
    const Bytes good = from_hex(kGood);
    bytes.insert(bytes.end(), good.begin(), good.end());
  }
  const Scan found = scan(bytes);
  CHECK(found.payloads.size() == 2);
  CHECK(found.rejects[Reject::bad_checksum] == 1);
}

TEST_CASE("a header whose blocks cannot fit is given up without waiting for its end") {
  FrameScanner scanner(block_1_has_4_bytes);
  RejectCounts rejects;
  const Bytes bytes = from_hex("aa 55 a0 01 04 c8 00 00 00 cb aa 55 06 01 04 c8 00 00 00 cb");
  REQUIRE(scanner.append(bytes) == bytes.size());
  // Block 0xCB would have 0xAA bytes: more than are left of 0xA0.
  CHECK(scanner.next(rejects).size() == 6);
}

TEST_CASE("more bytes than the buffer holds are taken in parts") {
  Bytes bytes;
  for (int i = 0; i < 500; ++i) {
    const Bytes good = from_hex(kGood);
    bytes.insert(bytes.end(), good.begin(), good.end());
    bytes.push_back(static_cast<std::uint8_t>(i));
  }
  CHECK(scan(bytes).payloads.size() == 500);
}

TEST_CASE("headers without end do not fill the buffer for ever") {
  const Bytes header = from_hex("aa 55 a0 63 9e");
  Bytes bytes;
  for (int i = 0; i < 2000; ++i) bytes.insert(bytes.end(), header.begin(), header.end());
  const Bytes good = from_hex(kGood);
  bytes.insert(bytes.end(), good.begin(), good.end());
  bytes.resize(bytes.size() + kMaxFrame_bytes);
  CHECK(scan(bytes).payloads.size() == 1);
}

TEST_CASE("a cleared scanner has forgotten what it had half read") {
  FrameScanner scanner(block_1_has_4_bytes);
  RejectCounts rejects;
  const Bytes good = from_hex(kGood);
  REQUIRE(scanner.append(std::span(good).first(6)) == 6);
  CHECK(scanner.next(rejects).empty());
  scanner.clear();
  REQUIRE(scanner.append(std::span(good).subspan(6)) == 4);
  CHECK(scanner.next(rejects).empty());
}

TEST_CASE("a frame is written with its length and checksum") {
  Bytes out(kMaxFrame_bytes);
  FrameWriter writer(out);
  writer.begin_block(1, 4);
  writer.put_u16(200);
  writer.put_u16(0);
  out.resize(writer.finish());
  CHECK(out == from_hex(kGood));
  CHECK(get_u16(out, 5) == 200);
  CHECK(get_u32(from_hex("78563412"), 0) == 0x12345678);
  CHECK(get_s16(from_hex("9cff"), 0) == -100);
}

TEST_CASE("blocks are taken one by one until one does not fit") {
  const Bytes payload = from_hex("01 02 aa bb 07 00 09 02 cc");
  std::span<const std::uint8_t> rest = payload;
  Block block;
  REQUIRE(take_block(rest, block));
  CHECK(block.id == 1);
  CHECK(block.data.size() == 2);
  REQUIRE(take_block(rest, block));
  CHECK(block.id == 7);
  CHECK(block.data.empty());
  CHECK_FALSE(take_block(rest, block));
}

}  // namespace
