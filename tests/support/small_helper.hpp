// SPDX-License-Identifier: Apache-2.0
// A helper process for a tiny camera and map.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "mapper/cuda/carried.hpp"
#include "mapper/cuda/helper_process.hpp"

namespace g3d::test {

/// What such a helper is started with; outlives what it is given to.
struct SmallSetup {
  std::vector<float> slopes = std::vector<float>(32, 0.0F);
  std::vector<std::uint16_t> mask = std::vector<std::uint16_t>(32 * 24, 3000);
  [[nodiscard]] mapper::cuda::HelperSetup setup() const {
    return {.program = mapper::cuda::carried_helper(),
            .kernels = mapper::cuda::carried_kernels(),
            .sizes = {32, 24, 512, 0, 256, 128, 128, 64, 2, 16, 0},
            .room = 16,
            .column_slope = slopes,
            .row_slope = std::span(slopes).first(24),
            .mask = mask,
            .patience_ns = 20'000'000'000};
  }
};

class SmallHelper {
 public:
  explicit SmallHelper(std::string_view kernels = mapper::cuda::carried_kernels(), std::uint32_t grid_cells = 0) {
    const SmallSetup small;
    mapper::cuda::HelperSetup setup = small.setup();
    setup.kernels = kernels;
    setup.sizes.grid_cells = grid_cells;
    helper_ = mapper::cuda::HelperProcess::start(setup, problem_);
  }
  [[nodiscard]] mapper::cuda::HelperState started() {
    return helper_ == nullptr ? mapper::cuda::HelperState::failed : helper_->wait_started(20'000'000'000);
  }
  [[nodiscard]] mapper::cuda::HelperProcess* get() { return helper_.get(); }
  mapper::cuda::HelperProcess* operator->() { return helper_.get(); }

 private:
  std::string problem_;
  std::unique_ptr<mapper::cuda::HelperProcess> helper_;
};

}  // namespace g3d::test
