// SPDX-License-Identifier: Apache-2.0
#include "net/set_sketch.hpp"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstdlib>
#include <cstring>

namespace g3d::net {

namespace {

static_assert(std::endian::native == std::endian::little, "ids are hashes of little-endian numbers");
static_assert(sizeof(SketchSalt) == crypto_shorthash_KEYBYTES && sizeof(SketchId) == crypto_shorthash_BYTES);

/// What keeps a decoder waiting are two differences that share all symbols: among d of them and m symbols that happens
/// with a chance of about 100 d^2 / m^4, so here below 2 of 10^6.
std::uint32_t most_sketch_symbols(std::uint32_t most_differences) {
  return static_cast<std::uint32_t>(
      std::min<std::uint64_t>(std::uint64_t{most_differences} * 2 + 1024, kMostSketchSymbols));
}

/// Salted as well, so that ids of another exchange are not believed; and not linear, so that sums of ids are not.
std::uint32_t sketch_check(const SketchSalt& salt, SketchId id) {
  return static_cast<std::uint32_t>(sketch_mix((id ^ salt.high) + salt.low) >> 32);
}

bool is_in_symbol(SketchId id, std::uint32_t index) {
  bool is_in = false;
  for_each_symbol_of(id, index, index + 1, [&](std::uint32_t) { is_in = true; });
  return is_in;
}

}  // namespace

const char* to_string(SketchState state) {
  switch (state) {
    case SketchState::wants_symbols:
      return "wants symbols";
    case SketchState::complete:
      return "complete";
    case SketchState::too_many_differences:
      return "too many differences";
    case SketchState::contradictory:
      return "contradictory";
  }
  return "?";
}

SketchId sketch_id(const SketchSalt& salt, std::uint64_t key, std::uint64_t version) {
  std::array<unsigned char, crypto_shorthash_KEYBYTES> hash_key;
  std::memcpy(hash_key.data(), &salt, hash_key.size());
  const std::array<std::uint64_t, 2> item{key, version};
  std::array<unsigned char, sizeof item> bytes;
  std::memcpy(bytes.data(), item.data(), bytes.size());
  std::array<unsigned char, crypto_shorthash_BYTES> hash;
  crypto_shorthash(hash.data(), bytes.data(), bytes.size(), hash_key.data());
  return std::bit_cast<SketchId>(hash);
}

SketchEncoder::SketchEncoder(const SketchSalt& salt, std::uint32_t first, std::span<SketchSymbol> symbols)
    : salt_(salt), first_(first), symbols_(symbols) {
  assert(symbols.size() <= kMostSketchSymbols && first <= kMostSketchSymbols - symbols.size());
  std::ranges::fill(symbols_, SketchSymbol{});
}

void SketchEncoder::add(SketchId id) {
  const SketchSymbol item{id, sketch_check(salt_, id), 1};
  for_each_symbol_of(id, first_, first_ + static_cast<std::uint32_t>(symbols_.size()),
                     [&](std::uint32_t index) { symbols_[index - first_].add(item); });
}

SketchDecoder::SketchDecoder(std::uint32_t most_differences)
    : most_differences_(std::min(most_differences, kMostSketchSymbols)),
      cells_(most_sketch_symbols(most_differences_)) {
  pending_.reserve(cells_.size());
  only_peers_.reserve(most_differences_);
  only_ours_.reserve(most_differences_);
}

void SketchDecoder::start(const SketchSalt& salt) {
  salt_ = salt;
  std::ranges::fill(cells_, Cell{});
  pending_.clear();
  only_peers_.clear();
  only_ours_.clear();
  taken_symbols_ = 0;
  state_ = SketchState::wants_symbols;
}

SketchState SketchDecoder::add(std::uint32_t first, std::span<const SketchSymbol> ours,
                               std::span<const SketchSymbol> peers) {
  assert(ours.size() == peers.size());
  if (state_ != SketchState::wants_symbols) return state_;
  for (std::size_t i = 0; i < peers.size() && first + i < cells_.size(); ++i) {
    Cell& cell = cells_[first + i];
    if (cell.is_taken) continue;
    cell.is_taken = true;
    ++taken_symbols_;
    cell.rest.add(peers[i]);
    cell.rest.subtract(ours[i]);
    note_pending(static_cast<std::uint32_t>(first + i));
  }
  peel();
  return state_;
}

bool SketchDecoder::names_item(std::uint32_t index) const {
  const SketchSymbol& rest = cells_[index].rest;
  return (rest.count == 1 || rest.count == -1) && rest.check_xor == sketch_check(salt_, rest.id_xor);
}

void SketchDecoder::note_pending(std::uint32_t index) {
  Cell& cell = cells_[index];
  if (!cell.is_taken || cell.is_pending || !names_item(index)) return;
  cell.is_pending = true;
  pending_.push_back(index);
}

void SketchDecoder::peel() {
  while (!pending_.empty() && state_ == SketchState::wants_symbols) {
    const std::uint32_t index = pending_.back();
    pending_.pop_back();
    cells_[index].is_pending = false;
    // Another symbol may have named the same item meanwhile.
    if (!names_item(index)) continue;
    const SketchSymbol item = cells_[index].rest;
    if (!is_in_symbol(item.id_xor, index)) continue;
    if (only_peers_.size() + only_ours_.size() == most_differences_) {
      state_ = SketchState::too_many_differences;
      return;
    }
    (item.count == 1 ? only_peers_ : only_ours_).push_back(item.id_xor);
    take_out(item);
  }
  if (state_ == SketchState::wants_symbols) state_ = judged();
}

void SketchDecoder::take_out(const SketchSymbol& item) {
  for_each_symbol_of(item.id_xor, 0, most_symbols(), [&](std::uint32_t index) {
    cells_[index].rest.subtract(item);
    note_pending(index);
  });
}

SketchState SketchDecoder::judged() {
  // Every item is in symbol 0. Sets of so different sizes differ by more than there is room for.
  const Cell& all = cells_[0];
  const std::uint64_t least_left = static_cast<std::uint64_t>(std::abs(std::int64_t{all.rest.count}));
  const std::uint64_t room = most_differences_ - only_peers_.size() - only_ours_.size();
  if (all.is_taken && least_left > room) return SketchState::too_many_differences;
  if (!all.is_taken || !all.rest.is_zero()) {
    return taken_symbols_ < most_symbols() ? SketchState::wants_symbols : SketchState::too_many_differences;
  }
  const auto is_left = [](const Cell& cell) { return cell.is_taken && !cell.rest.is_zero(); };
  if (std::ranges::any_of(cells_, is_left)) return SketchState::contradictory;
  std::ranges::sort(only_peers_);
  std::ranges::sort(only_ours_);
  // The same item to and fro: a false name that was taken back.
  const auto is_twice = [](const std::vector<SketchId>& ids) { return std::ranges::adjacent_find(ids) != ids.end(); };
  const bool is_to_and_fro =
      std::ranges::any_of(only_ours_, [&](SketchId id) { return std::ranges::binary_search(only_peers_, id); });
  if (is_twice(only_peers_) || is_twice(only_ours_) || is_to_and_fro) return SketchState::contradictory;
  return SketchState::complete;
}

}  // namespace g3d::net
