// SPDX-License-Identifier: Apache-2.0
// Which thread runs where and how urgently, as a board file says it:
//
//   "base=fifo40@5 navigator=rr10@4 mapper=@1,2 mapper_worker=@1-2 *=@0,3-5"
//
// Words of NAME=[fifoN|rrN][@CPUS], by the names that threads give themselves; `*` is every other one. The plan is put
// into effect from outside, thread by thread, so that it also holds for threads that begin later.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "hal/result.hpp"

namespace g3d::hal {

inline constexpr int kMostCpus = 64;

struct ThreadRule {
  enum class Policy : std::uint8_t { leave, fifo, round_robin };
  std::string name;  ///< at most 15 characters; "*": all that no other rule names
  Policy policy = Policy::leave;
  int priority = 0;        ///< 1 to 99
  std::uint64_t cpus = 0;  ///< bit n: CPU n; 0: as it is
  bool operator==(const ThreadRule&) const = default;
};
using ThreadPlan = std::vector<ThreadRule>;

/// "none" is an empty plan. Errors: malformed, out_of_range; they name the word.
[[nodiscard]] Result<ThreadPlan> parse_thread_plan(std::string_view text);
/// "0,3-5" as bits; nothing if it is no such list.
[[nodiscard]] bool parse_cpu_list(std::string_view text, std::uint64_t& cpus);
/// The rule for a thread of that name, or nullptr.
[[nodiscard]] const ThreadRule* rule_for(const ThreadPlan& plan, std::string_view name);

struct ThreadPlanCounts {
  std::uint64_t settled = 0;        ///< threads for which the whole rule holds
  std::uint64_t no_permission = 0;  ///< could not be made as urgent as it says: no CAP_SYS_NICE, no rtprio limit
  std::uint64_t no_cpu = 0;         ///< none of its CPUs is online
  std::uint64_t failed = 0;         ///< another refusal
};

/// Puts a plan into effect for the threads of this process.
class ThreadSettler {
 public:
  /// `tasks`: the folder with a folder for each thread, "/proc/self/task"; `online`: the file with the CPUs that there
  /// are. Tests have their own.
  explicit ThreadSettler(ThreadPlan plan, std::string tasks = "/proc/self/task",
                         std::string online = "/sys/devices/system/cpu/online");
  /// Every thread that was not seen yet under its present name. One thread, which may wait for the kernel.
  void settle();
  [[nodiscard]] const ThreadPlanCounts& counts() const { return counts_; }

 private:
  struct Seen {
    int thread = 0;
    std::string name;
  };
  void apply(const ThreadRule& rule, int thread);

  const ThreadPlan plan_;
  const std::string tasks_, online_;
  std::vector<Seen> seen_;
  ThreadPlanCounts counts_;
};

}  // namespace g3d::hal
