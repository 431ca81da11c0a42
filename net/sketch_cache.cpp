// SPDX-License-Identifier: Apache-2.0
#include "net/sketch_cache.hpp"

#include <algorithm>
#include <cassert>

namespace g3d::net {

SketchCache::SketchCache() : symbols_(kMostAhead) {}

std::span<const SketchSymbol> SketchCache::symbols(const LayerStore& store, LayerIndex layer, const SketchSalt& salt,
                                                   std::uint32_t first, std::uint32_t count) {
  assert(count <= kMostAhead && first <= kMostSketchSymbols - count);
  const bool is_held = layer == layer_ && salt == salt_ && store.content_hash(layer) == content_hash_ &&
                       first >= first_ && first + count <= first_ + count_;
  if (!is_held) {
    constexpr std::uint32_t kLeastAhead = 64;
    layer_ = layer;
    salt_ = salt;
    content_hash_ = store.content_hash(layer);
    first_ = first;
    // As many again as the asker has by now.
    count_ = std::min({std::max({count, kLeastAhead, first}), kMostAhead, kMostSketchSymbols - first});
    const std::span<SketchSymbol> made = std::span(symbols_).first(count_);
    SketchEncoder encoder(salt, first, made);
    store.for_each(layer,
                   [&](const StoredRecord& record) { encoder.add(sketch_id(salt, record.key, record.version)); });
    ++passes_;
  }
  return std::span(symbols_).subspan(first - first_, count);
}

}  // namespace g3d::net
