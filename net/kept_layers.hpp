// SPDX-License-Identifier: Apache-2.0
// A store and, where a robot has a folder for that, what keeps it over restarts. One thread.
#pragma once

#include <memory>

#include "net/layer_keeper.hpp"
#include "net/layer_store.hpp"

namespace g3d::net {

struct KeptLayers {
  explicit KeptLayers(const StoreLimits& limits) : store(limits) {}

  /// With all that lies in the folder. Errors: see LayerKeeper::open().
  [[nodiscard]] static hal::Result<std::unique_ptr<KeptLayers>> open(const KeeperOptions& options,
                                                                     const StoreLimits& limits) {
    auto kept = std::make_unique<KeptLayers>(limits);
    auto keeper = LayerKeeper::open(options, kept->store);
    if (!keeper) return keeper.error();
    kept->keeper = std::move(keeper).value();
    return kept;
  }

  LayerStore store;
  std::unique_ptr<LayerKeeper> keeper;  ///< nullptr: a restart begins with nothing
};

}  // namespace g3d::net
