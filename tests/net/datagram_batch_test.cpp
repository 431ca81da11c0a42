// SPDX-License-Identifier: Apache-2.0
#include "net/datagram_batch.hpp"

#include <catch2/catch.hpp>
#include <vector>

using namespace g3d;
using namespace g3d::net;

namespace {

std::vector<mapper::Bytes> unpacked(const mapper::Bytes& batch) {
  std::vector<mapper::Bytes> datagrams;
  visit_datagrams(batch, [&](mapper::ByteSpan datagram) { datagrams.emplace_back(datagram.begin(), datagram.end()); });
  return datagrams;
}

}  // namespace

TEST_CASE("datagrams come out of a batch as they went in") {
  std::vector<mapper::Bytes> datagrams;
  mapper::Bytes batch;
  for (const std::size_t bytes : {std::size_t{1}, std::size_t{255}, std::size_t{256}, kMostDatagram_bytes}) {
    datagrams.emplace_back(bytes, static_cast<std::uint8_t>(bytes));
    append_datagram(batch, datagrams.back());
  }
  CHECK(batch.size() == 1 + 255 + 256 + kMostDatagram_bytes + 4 * kBatchedLength_bytes);
  CHECK(datagrams_of(batch) == 4);
  CHECK(unpacked(batch) == datagrams);
}

TEST_CASE("a batch that is cut anywhere but between datagrams is none") {
  mapper::Bytes batch;
  append_datagram(batch, mapper::Bytes(3, 1));
  append_datagram(batch, mapper::Bytes(300, 2));
  for (std::size_t bytes = 0; bytes < batch.size(); ++bytes) {
    CHECK(datagrams_of(mapper::ByteSpan(batch).first(bytes)) == (bytes == 5 ? 1 : 0));
  }
}

TEST_CASE("a batch with an empty or overlong datagram is none") {
  mapper::Bytes batch;
  append_datagram(batch, mapper::Bytes(10, 1));
  mapper::Bytes with_empty = batch;
  append_datagram(with_empty, {});
  CHECK(datagrams_of(with_empty) == 0);
  append_datagram(batch, mapper::Bytes(kMostDatagram_bytes + 1, 1));
  CHECK(datagrams_of(batch) == 0);
}
