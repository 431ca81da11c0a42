// SPDX-License-Identifier: Apache-2.0
// Symbols of a peer's set from hostile hands. The first byte says how many of our items the peer has, and how many
// others; the second picks the way in: the rest as a message, or patches to the honest message. What is read is written
// to the same bytes again. A decoder that is given it ends with its memory; if it says that it is complete, then what
// it says, put into our set, makes each of the symbols that came.
#include <algorithm>
#include <array>
#include <cstdlib>

#include "net/set_sketch_wire.hpp"

namespace {

using namespace g3d;
using namespace g3d::net;

constexpr std::size_t kMaxInput_bytes = 4096;
constexpr std::uint32_t kDifferences = 40;
constexpr std::size_t kOurItems = 20;
constexpr SketchSalt kSalt{7, 9};

void check(bool holds) {
  if (!holds) std::abort();
}

SketchId item(std::uint64_t n) { return sketch_id(kSalt, n, 1); }

std::vector<SketchSymbol> our_symbols(std::uint32_t first, std::size_t count) {
  std::vector<SketchSymbol> symbols(count);
  SketchEncoder encoder(kSalt, first, symbols);
  for (std::uint64_t n = 0; n < kOurItems; ++n) encoder.add(item(n));
  return symbols;
}

mapper::Bytes honest_message(std::uint8_t kind) {
  std::vector<SketchSymbol> symbols(60);
  SketchEncoder encoder(kSalt, 0, symbols);
  const std::uint32_t items = kind / 16U + kind % 16U;
  for (std::uint64_t n = 0; n < items; ++n) encoder.add(item(n < kind / 16U ? n : n + 100));
  mapper::Bytes bytes(1200);
  bytes.resize(write_sketch({kSalt, 0, items}, symbols, bytes).bytes);
  return bytes;
}

void check_answer(const SketchDecoder& decoder, const SketchMessage& message) {
  const std::size_t size = std::min<std::size_t>(message.symbol_count, decoder.most_symbols() - message.header.first);
  std::vector<SketchSymbol> expected = our_symbols(message.header.first, size), added(size), removed(size);
  SketchEncoder(kSalt, message.header.first, added).add(decoder.only_peers());
  SketchEncoder(kSalt, message.header.first, removed).add(decoder.only_ours());
  for (std::size_t i = 0; i < size; ++i) {
    expected[i].add(added[i]);
    expected[i].subtract(removed[i]);
    check(expected[i] == message.symbols[i]);
  }
  check(decoder.only_peers().size() + decoder.only_ours().size() <= kDifferences);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  if (size_bytes < 2 || size_bytes > kMaxInput_bytes) return -1;
  const mapper::ByteSpan rest(data + 2, size_bytes - 2);
  mapper::Bytes bytes(rest.begin(), rest.end());
  if (data[1] % 2 == 1) {
    bytes = honest_message(data[0]);
    for (std::size_t i = 0; i + 3 <= rest.size(); i += 3) {
      bytes[(rest[i] | std::size_t{rest[i + 1]} << 8) % bytes.size()] ^= rest[i + 2];
    }
  }
  SketchMessage message;
  if (read_sketch(bytes, message) != SketchFault::none) return 0;
  mapper::Bytes again(bytes.size());
  const SketchWritten written = write_sketch(message.header, message.used(), again);
  check(written.symbols == message.symbol_count && written.bytes == bytes.size() && again == bytes);

  static SketchDecoder decoder(kDifferences);
  decoder.start(kSalt);
  const std::uint32_t first = message.header.first;
  const SketchState state = decoder.add(first, our_symbols(first, message.symbol_count), message.used());
  check(decoder.taken_symbols() <= message.symbol_count);
  if (state == SketchState::complete) {
    check_answer(decoder, message);
  } else {
    check(decoder.only_peers().empty() && decoder.only_ours().empty());
  }
  return 0;
}
