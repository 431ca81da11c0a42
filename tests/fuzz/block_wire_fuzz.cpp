// SPDX-License-Identifier: Apache-2.0
// Blocks from the network. Any bytes are refused, and then nothing is written, or give codes that a map can have; these
// come back from their own packing, whole and in halves. The first byte picks the part, and whether the rest is taken
// as packed bytes or as codes to be packed.
#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "net/block_wire.hpp"

namespace {

using namespace g3d;
using namespace g3d::net;

void check(bool holds) {
  if (!holds) std::abort();
}

void check_round_trip(const mapper::BlockValues& values) {
  static BlockPacker packer;
  static BlockUnpacker unpacker;
  for (const std::size_t limit : {std::size_t{0}, kDefaultBlockLimit_bytes}) {
    mapper::BlockValues back{};
    for (const PackedPart& part : packer.pack_within(values, limit)) {
      check(part.bytes.size() <= max_bytes_of(part.part));
      check(unpacker.unpack(part.bytes, part.part, back) == UnpackError::none);
    }
    check(std::equal(values.begin(), values.end(), back.begin(),
                     [](mapper::Rgbo a, mapper::Rgbo b) { return tellable(a) == b; }));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  if (size_bytes < 1) return 0;
  const ByteSpan rest(data + 1, size_bytes - 1);
  mapper::BlockValues values;
  values.fill(mapper::kUnknownRgbo);
  if (data[0] >= 0xC0) {
    // Few kinds of codes in long runs, as maps have them, and any codes where the bytes say so.
    for (std::size_t i = 0; i < values.size() && !rest.empty(); ++i) {
      std::memcpy(&values[i], rest.data() + i * 4 % rest.size(),
                  std::min<std::size_t>(4, rest.size() - i * 4 % rest.size()));
    }
    check_round_trip(values);
    return 0;
  }
  static BlockUnpacker unpacker;
  const Part part = static_cast<Part>(data[0] % 3);
  const mapper::BlockValues before = values;
  const UnpackError error = unpacker.unpack(rest, part, values);
  check(error == UnpackError::none || values == before);
  check(std::all_of(values.begin(), values.end(), [](mapper::Rgbo value) { return value == tellable(value); }));
  if (error == UnpackError::none) check_round_trip(values);
  return 0;
}
