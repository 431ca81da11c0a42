// SPDX-License-Identifier: Apache-2.0
// How few bytes a changed block takes on the wire, against zstd (level 3, one frame per block of its 2048 bytes of
// published codes), which coding is chosen how often, and how long packing and unpacking take.
//   block_wire_bench [MAP.g3d | EARLIER.g3d:LATER.g3d | FOLDER@RESOLUTION]...
// A map: all its blocks. Two: those of the later that differ. A TUM folder: blocks that changed while it was mapped.
// Without arguments: two flights of whose worlds the trained tables know nothing.
#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>

#include "net/block_wire.hpp"
#include "tests/support/changed_blocks.hpp"

using namespace g3d;

namespace {

/// CPU time of this thread: other programs do not count.
double now_us() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e6 + static_cast<double>(t.tv_nsec) * 1e-3;
}

struct Figures {
  std::size_t bytes = 0;
  std::size_t zstd_bytes = 0;
  std::size_t longest = 0;
  std::size_t halved = 0;
  std::size_t wrong = 0;
  std::array<std::size_t, 5> codings{};  ///< uniform, raw, palette, runs, coded
};

std::size_t coding_of(std::uint8_t first) {
  if (first <= mapper::kMaxLevel) return 0;
  return first == net::kRawByte ? 1 : first == net::kPaletteByte ? 2 : first == net::kRunsByte ? 3 : 4;
}

std::size_t zstd_bytes_of(const mapper::BlockValues& values, ZSTD_CCtx* zstd) {
  static std::array<std::uint8_t, 4096> out;
  mapper::BlockValues codes;
  std::transform(values.begin(), values.end(), codes.begin(), mapper::published);
  return ZSTD_compressCCtx(zstd, out.data(), out.size(), codes.data(), sizeof codes, 3);
}

void measure(const std::string& name, const std::vector<mapper::BlockValues>& blocks) {
  if (blocks.empty()) {
    fmt::print(stderr, "block_wire_bench: no blocks in {}\n", name);
    std::exit(1);
  }
  net::BlockPacker packer;
  net::BlockUnpacker unpacker;
  ZSTD_CCtx* zstd = ZSTD_createCCtx();
  Figures f;
  std::vector<std::vector<std::uint8_t>> packed;
  for (const mapper::BlockValues& values : blocks) {
    const mapper::ByteSpan bytes = packer.pack(values, net::Part::whole);
    packed.emplace_back(bytes.begin(), bytes.end());
    f.bytes += bytes.size();
    f.longest = std::max(f.longest, bytes.size());
    f.halved += bytes.size() > net::kDefaultBlockLimit_bytes;
    ++f.codings[coding_of(bytes[0])];
    f.zstd_bytes += zstd_bytes_of(values, zstd);
  }
  ZSTD_freeCCtx(zstd);
  double pack_us = 1e18;
  double unpack_us = 1e18;
  mapper::BlockValues back;
  for (int round = 0; round < 3; ++round) {
    const double start = now_us();
    for (const mapper::BlockValues& values : blocks) (void)packer.pack(values, net::Part::whole);
    pack_us = std::min(pack_us, now_us() - start);
    const double middle = now_us();
    f.wrong = 0;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const net::UnpackError error = unpacker.unpack(packed[i], net::Part::whole, back);
      f.wrong += error != net::UnpackError::none || back != blocks[i];
    }
    unpack_us = std::min(unpack_us, now_us() - middle);
  }
  const double n = static_cast<double>(blocks.size());
  const auto percent = [&](std::size_t count) { return 100.0 * static_cast<double>(count) / n; };
  fmt::print(
      "{:28} {:6} blocks: {:6.1f} bytes, zstd {:6.1f}, ratio {:.3f}; longest {}, halved {}; uniform {:.1f}% raw "
      "{:.1f}% "
      "palette {:.1f}% runs {:.1f}% coded {:.1f}%; pack {:.1f} us, unpack {:.1f} us{}\n",
      name, blocks.size(), static_cast<double>(f.bytes) / n, static_cast<double>(f.zstd_bytes) / n,
      static_cast<double>(f.bytes) / static_cast<double>(f.zstd_bytes), f.longest, f.halved, percent(f.codings[0]),
      percent(f.codings[1]), percent(f.codings[2]), percent(f.codings[3]), percent(f.codings[4]), pack_us / n,
      unpack_us / n, f.wrong == 0 ? "" : fmt::format("; {} CAME BACK WRONG", f.wrong));
  std::fflush(stdout);
  if (f.wrong != 0) std::exit(1);
}

std::vector<mapper::BlockValues> blocks_of(const std::string& argument) {
  if (const std::size_t at = argument.find('@'); at != std::string::npos) {
    const auto resolution_m = static_cast<float>(std::atof(argument.c_str() + at + 1));
    return test::changed_blocks(test::recorded(argument.substr(0, at), 200), resolution_m, 10, 400);
  }
  const std::size_t colon = argument.find(':');
  if (colon == std::string::npos) return test::all_blocks(argument);
  return test::changed_blocks(argument.substr(0, colon), argument.substr(colon + 1));
}

}  // namespace

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) measure(argv[i], blocks_of(argv[i]));
  if (argc > 1) return 0;
  measure("corridor at 5 cm",
          test::changed_blocks(test::simulated_drive("corridor", 240, 0.1, 0.0, 320), 0.05F, 10, 200));
  measure("two_rooms at 2 cm",
          test::changed_blocks(test::simulated_drive("two_rooms", 120, 0.1, 0.0, 320), 0.02F, 10, 400));
  return 0;
}
