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

class SmallHelper {
 public:
  explicit SmallHelper(std::string_view kernels = mapper::cuda::carried_kernels(), std::uint32_t grid_cells = 0) {
    const std::vector<float> slopes(32, 0.0F);
    const std::vector<std::uint16_t> mask(32 * 24, 3000);
    helper_ = mapper::cuda::HelperProcess::start({.program = mapper::cuda::carried_helper(),
                                                  .kernels = kernels,
                                                  .sizes = {32, 24, 512, 0, 256, 128, 128, 64, 2, 16, grid_cells},
                                                  .room = 16,
                                                  .column_slope = slopes,
                                                  .row_slope = std::span(slopes).first(24),
                                                  .mask = mask,
                                                  .patience_ns = 20'000'000'000},
                                                 problem_);
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
