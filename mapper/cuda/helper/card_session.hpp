// SPDX-License-Identifier: Apache-2.0
// The helper's side of a card: memory, kernels, and the sequence of launches of one frame.
#pragma once

#include "mapper/cuda/helper/driver.hpp"
#include "mapper/cuda/helper_protocol.hpp"

namespace g3d::mapper::cuda {

class CardSession {
 public:
  /// False: control.problem says why.
  [[nodiscard]] bool start(HelperControl& control);
  /// Does what control.command says.
  [[nodiscard]] bool obey();

 private:
  enum Kernel { kImport, kRead, kWalk, kFind, kUpdateByOne, kUpdateByFour, kExport, kKernelCount };

  [[nodiscard]] bool check(int result, const char* what);
  [[nodiscard]] bool make_context();
  [[nodiscard]] bool load_kernels();
  [[nodiscard]] bool make_memory();
  [[nodiscard]] bool make_graph(CuHandle& graph, bool with_copies);
  [[nodiscard]] bool launch(Kernel kernel, unsigned blocks, unsigned threads, void** arguments);
  /// One launch of a frame; nothing where the integrator has none.
  [[nodiscard]] bool launch_step(int kernel);
  [[nodiscard]] bool launch_export(std::uint32_t first);
  [[nodiscard]] bool copy_depth();
  [[nodiscard]] bool copy_colour(CuHandle stream);
  [[nodiscard]] bool launch_frame(bool with_copies);
  [[nodiscard]] bool run_frame();
  [[nodiscard]] bool run_timed();
  [[nodiscard]] bool run_stages();
  [[nodiscard]] bool import_blocks(std::uint32_t count);
  [[nodiscard]] bool send_blocks(std::uint32_t first);
  [[nodiscard]] bool fetch_parcels(std::uint32_t first);
  template <typename T>
  [[nodiscard]] T* shared(std::uint64_t offset) const {
    return reinterpret_cast<T*>(reinterpret_cast<char*>(control_) + offset);
  }

  HelperControl* control_ = nullptr;
  Driver driver_{};
  int device_ = 0;
  CuHandle stream_ = nullptr;
  CuHandle kernels_[kKernelCount] = {};
  unsigned at_once_[kKernelCount] = {};  ///< blocks of threads that the card runs side by side
  CuHandle copy_stream_ = nullptr;
  CuHandle whole_graph_ = nullptr;   ///< copies and launches
  CuHandle launch_graph_ = nullptr;  ///< launches alone
  CuHandle events_[kStages + 1] = {};
  CuHandle begun_ = nullptr;  ///< between the two streams
  CuHandle colour_there_ = nullptr;
  CuDevicePointer memory_symbol_ = 0;
  CuDevicePointer params_symbol_ = 0;
  CuDevicePointer base_ = 0;
  CuDevicePointer card_counters_ = 0;
  Memory memory_{};
  Parcels parcels_{};  ///< as the card sees them
  bool mapped_ = false;
  unsigned processors_ = 1;
  bool by_four_ = false;  ///< warps for a block of the map, else one
};

}  // namespace g3d::mapper::cuda
