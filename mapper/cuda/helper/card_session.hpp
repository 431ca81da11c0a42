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
  enum Kernel { kImport, kRead, kWalk, kFind, kUpdateByOne, kUpdateByFour, kClasses, kExport, kKernelCount };
  enum Question {
    kReadColumns,
    kCastRays,
    kMarkLooks,
    kCountLooks,
    kBeginSpread,
    kSpreadRound,
    kReadTiles,
    kFindSamples,
    kCountChosen,
    kChoose,
    kMatchStep,
    kPlaceSamples,
    kLeadCells,
    kAddSamples,
    kSweepCells,
    kExportCells,
    kImportCells,
    kQuestionCount
  };

  [[nodiscard]] bool check(int result, const char* what);
  [[nodiscard]] bool make_context();
  [[nodiscard]] bool load_kernels();
  [[nodiscard]] bool load_questions(CuHandle module);
  [[nodiscard]] bool make_memory();
  /// What of a frame is launched together.
  enum class Part { until_colours, from_colours, launches_alone };
  [[nodiscard]] bool make_graph(CuHandle& graph, Part part);
  /// What `launches()` hands to the stream, as one graph. Without graphs here none is made, and that is no failure.
  template <typename Launches>
  [[nodiscard]] bool capture(CuHandle& graph, const Launches& launches) {
    constexpr int kRelaxed = 2;  // CU_STREAM_CAPTURE_MODE_RELAXED
    // Whether a graph keeps to a stream's multiprocessors is not said anywhere.
    if (confined_ || driver_.stream_begin_capture == nullptr || driver_.stream_end_capture == nullptr ||
        driver_.graph_instantiate == nullptr || driver_.graph_launch == nullptr) {
      return true;
    }
    CuHandle captured = nullptr;
    return check(driver_.stream_begin_capture(stream_, kRelaxed), "graph") && launches() &&
           check(driver_.stream_end_capture(stream_, &captured), "graph") &&
           check(driver_.graph_instantiate(&graph, captured, 0), "graph");
  }
  [[nodiscard]] bool launch(Kernel kernel, unsigned blocks, unsigned threads, void** arguments);
  /// One launch of a frame; nothing where the integrator has none.
  [[nodiscard]] bool launch_step(int kernel);
  [[nodiscard]] bool launch_classes();
  [[nodiscard]] bool launch_export(std::uint32_t first);
  [[nodiscard]] bool launch_part(Part part);
  [[nodiscard]] bool run_part(CuHandle graph, Part part);
  [[nodiscard]] bool wait_for_colours();
  [[nodiscard]] bool copy_depth();
  [[nodiscard]] bool copy_colour();
  [[nodiscard]] bool run_frame();
  [[nodiscard]] bool run_timed();
  [[nodiscard]] bool run_stages();
  [[nodiscard]] bool import_blocks(std::uint32_t count);
  [[nodiscard]] bool send_blocks(std::uint32_t first);
  /// So many tasks, one block of threads for each; fewer blocks stride over them where they would not fit.
  [[nodiscard]] bool ask(Question question, CuHandle stream, std::uint64_t tasks, unsigned threads, void** arguments);
  [[nodiscard]] bool finish_question(CuHandle stream);
  /// For what events_[0] has begun.
  [[nodiscard]] bool wait_timed(CuHandle stream);
  [[nodiscard]] bool set_columns();
  [[nodiscard]] bool read_columns(std::uint32_t first);
  [[nodiscard]] bool spread_grid();
  [[nodiscard]] bool cast_rays(std::uint32_t count);
  [[nodiscard]] bool count_looks(std::uint32_t count);
  [[nodiscard]] bool import_cells(std::uint32_t first, std::uint32_t count);
  [[nodiscard]] bool launch_fit(int most_steps);
  [[nodiscard]] bool fit_frame();
  [[nodiscard]] bool add_samples();
  [[nodiscard]] bool fetch(std::uint64_t offset, const void* from, std::uint64_t bytes);
  [[nodiscard]] bool fetch_classes();
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
  CuHandle questions_[kQuestionCount] = {};
  CuHandle side_stream_ = nullptr;  ///< beside the frame's
  unsigned questions_at_once_[kQuestionCount] = {};
  CuHandle first_graph_ = nullptr;  ///< a frame up to where it needs colours
  CuHandle last_graph_ = nullptr;
  CuHandle launch_graph_ = nullptr;  ///< all launches without copies
  CuHandle fit_graph_ = nullptr;     ///< for so many steps:
  int fit_graph_steps_ = -1;
  CuHandle events_[kStages + 1] = {};
  CuHandle classes_there_ = nullptr;
  CuDevicePointer memory_symbol_ = 0;
  CuDevicePointer params_symbol_ = 0;
  CuDevicePointer base_ = 0;
  CuDevicePointer card_counters_ = 0;
  Memory memory_{};
  Parcels parcels_{};  ///< as the card sees them
  Classes classes_{};
  bool first_parcels_sent_ = false;
  bool mapped_ = false;
  unsigned processors_ = 1;  ///< multiprocessors
  bool confined_ = false;    ///< to fewer than the card has
  bool by_four_ = false;     ///< warps for a block of the map, else one
};

}  // namespace g3d::mapper::cuda
