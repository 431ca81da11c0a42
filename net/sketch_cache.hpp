// SPDX-License-Identifier: Apache-2.0
// The symbols of one layer under one salt, made ahead: whoever asks for few at a time would else cost a pass over all
// records for each question, and a pass costs little more for twice the symbols. Soft state: what it holds can be made
// again at any time. One thread. Allocates at construction only.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "net/layer_store.hpp"
#include "net/set_sketch.hpp"

namespace g3d::net {

class SketchCache {
 public:
  SketchCache();
  /// Symbols [first, first + count) of what the layer holds now; they stand until the next call.
  /// Preconditions: count <= kMostAhead, and the last one is below kMostSketchSymbols.
  [[nodiscard]] std::span<const SketchSymbol> symbols(const LayerStore& store, LayerIndex layer, const SketchSalt& salt,
                                                      std::uint32_t first, std::uint32_t count);
  /// Over all records of a layer.
  [[nodiscard]] std::uint64_t passes() const { return passes_; }

  static constexpr std::uint32_t kMostAhead = 2048;

 private:
  LayerIndex layer_ = kNoLayer;
  std::uint64_t content_hash_ = 0;
  SketchSalt salt_;
  std::uint32_t first_ = 0;
  std::uint32_t count_ = 0;
  std::uint64_t passes_ = 0;
  std::vector<SketchSymbol> symbols_;
};

}  // namespace g3d::net
