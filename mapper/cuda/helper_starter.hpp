// SPDX-License-Identifier: Apache-2.0
// Starts helper processes on a thread of its own: to lay out the memory that is shared with one and to fork takes a
// millisecond or more, however large the map is. No locks: one word says whose turn it is. The rest is the mapper
// thread's.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>

#include "mapper/cuda/helper_process.hpp"

namespace g3d::mapper::cuda {

class HelperStarter {
 public:
  /// What `setup` points at outlives this and stays as it is.
  explicit HelperStarter(const HelperSetup& setup);
  ~HelperStarter();
  HelperStarter(const HelperStarter&) = delete;
  HelperStarter& operator=(const HelperStarter&) = delete;

  /// Has a helper started, unless one is under way already.
  void ask();
  [[nodiscard]] bool is_under_way() const { return turn_.load(std::memory_order_relaxed) != Turn::nobody; }
  /// False: there is nothing yet. Else the helper that was asked for, or nullptr and a problem.
  bool take(std::shared_ptr<HelperProcess>& helper, std::string& problem);

 private:
  enum class Turn : std::uint32_t { nobody, starter, mapper, end };
  void run();

  HelperSetup setup_;
  std::atomic<Turn> turn_{Turn::nobody};
  // Of whose turn it is
  std::unique_ptr<HelperProcess> started_;
  std::string problem_;
  std::thread thread_;
};

}  // namespace g3d::mapper::cuda
