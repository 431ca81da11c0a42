// SPDX-License-Identifier: Apache-2.0
// The whole of a map whose view holds only what is around the camera: the view's regions from the view, the others from
// the submaps, a few of which are in memory at a time.
#pragma once

#include "mapper/block_source.hpp"
#include "mapper/submaps/submap_chain.hpp"
#include "mapper/submaps/view_window.hpp"

namespace g3d::mapper::submaps {

/// References outlive this; nobody writes to either while it is read.
class SubmapBlocks final : public BlockSource {
 public:
  static constexpr std::size_t kKept = 16;  ///< submaps in memory; a region is seldom in more

  SubmapBlocks(SubmapChain& chain, const ViewWindow& window) : chain_(chain), window_(window) {}
  [[nodiscard]] const Grid& grid() const override { return chain_.view().grid(); }
  hal::Result<void> visit_regions(const Visit& visit) const override;

 private:
  SubmapChain& chain_;
  const ViewWindow& window_;
};

}  // namespace g3d::mapper::submaps
