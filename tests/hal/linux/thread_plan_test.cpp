// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/thread_plan.hpp"

#include <pthread.h>
#include <sched.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <thread>

#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::hal;

namespace {

/// A thread of that name that waits until it may go.
struct NamedThread {
  explicit NamedThread(const char* name)
      : thread([this, name] {
          (void)pthread_setname_np(pthread_self(), name);
          id.store(::gettid());
          while (!ending.load()) std::this_thread::yield();
        }) {
    while (id.load() == 0) std::this_thread::yield();
  }
  ~NamedThread() {
    ending.store(true);
    thread.join();
  }
  std::uint64_t cpus() const {
    cpu_set_t set;
    CPU_ZERO(&set);
    REQUIRE(::sched_getaffinity(id.load(), sizeof set, &set) == 0);
    std::uint64_t bits = 0;
    for (unsigned i = 0; i < kMostCpus; ++i) bits |= std::uint64_t{CPU_ISSET(i, &set) != 0} << i;
    return bits;
  }
  std::atomic<int> id{0};
  std::atomic<bool> ending{false};
  std::thread thread;
};

std::string plan_error(std::string_view text) {
  const auto plan = parse_thread_plan(text);
  REQUIRE_FALSE(plan.ok());
  return plan.error().text;
}

}  // namespace

TEST_CASE("Plans are read word by word", "[threads]") {
  const auto plan = parse_thread_plan("base=fifo40@5  navigator=rr10@4 mapper=@1,2 *=@0,3-5 sharing=fifo1");
  REQUIRE(plan.ok());
  using Policy = ThreadRule::Policy;
  CHECK(plan.value() == ThreadPlan{{"base", Policy::fifo, 40, 1U << 5},
                                   {"navigator", Policy::round_robin, 10, 1U << 4},
                                   {"mapper", Policy::leave, 0, 0b110},
                                   {"*", Policy::leave, 0, 0b111001},
                                   {"sharing", Policy::fifo, 1, 0}});
  CHECK(parse_thread_plan("none").value().empty());
  CHECK(rule_for(plan.value(), "base")->priority == 40);
  CHECK(rule_for(plan.value(), "camera")->name == "*");
  CHECK(rule_for({}, "base") == nullptr);
  CHECK(plan_error("base").find("threads.plan: 'base' is not NAME=") == 0);
  CHECK(plan_error("base=").find("neither") != std::string::npos);
  CHECK(plan_error("base=fifo0").find("priority of 1 to 99") != std::string::npos);
  CHECK(plan_error("base=fifo100").find("priority") != std::string::npos);
  CHECK(plan_error("base=batch1").find("another policy") != std::string::npos);
  CHECK(plan_error("base=@").find("list of CPUs") != std::string::npos);
  CHECK(plan_error("base=@3-1").find("list of CPUs") != std::string::npos);
  CHECK(plan_error("base=@64").find("list of CPUs") != std::string::npos);
  CHECK(plan_error("base=@1,").find("list of CPUs") != std::string::npos);
  CHECK(plan_error("a=@1 a=@2").find("second time") != std::string::npos);
  CHECK(plan_error("averyveryverylongname=@1").find("is not NAME=") != std::string::npos);
}

TEST_CASE("Threads are put where the plan wants them, also those that begin later", "[threads]") {
  const NamedThread first("plan_first"), other("plan_other");
  const std::uint64_t before = first.cpus();
  const int cpu = std::countr_zero(before);
  const std::uint64_t one = std::uint64_t{1} << cpu;
  ThreadSettler settler(
      parse_thread_plan("plan_first=@" + std::to_string(cpu) + " plan_late=@" + std::to_string(cpu)).value());
  settler.settle();
  CHECK(first.cpus() == one);
  CHECK(other.cpus() == before);
  CHECK(settler.counts().settled == 1);
  settler.settle();
  CHECK(settler.counts().settled == 1);  // once is enough
  const NamedThread late("plan_late");
  settler.settle();
  CHECK(late.cpus() == one);
  CHECK(settler.counts().settled == 2);
}

TEST_CASE("CPUs that are not online are counted, not obeyed", "[threads]") {
  const test::TempFolder folder;
  test::write_plain(folder / "online", "0,3-5\n");  // a TX2 whose Denver cores sleep
  const NamedThread thread("plan_denver");
  const std::uint64_t before = thread.cpus();
  ThreadSettler settler(parse_thread_plan("plan_denver=@1-2").value(), "/proc/self/task", folder / "online");
  settler.settle();
  CHECK(thread.cpus() == before);
  CHECK(settler.counts().no_cpu == 1);
  CHECK(settler.counts().settled == 0);
}

TEST_CASE("Urgency is given where it is permitted, and counted where not", "[threads]") {
  const NamedThread thread("plan_urgent");
  ThreadSettler settler(parse_thread_plan("plan_urgent=rr3").value());
  settler.settle();
  const auto& counts = settler.counts();
  REQUIRE(counts.settled + counts.no_permission == 1);
  sched_param parameters{};
  REQUIRE(::sched_getparam(thread.id.load(), &parameters) == 0);
  CHECK((::sched_getscheduler(thread.id.load()) == SCHED_RR) == (counts.settled == 1));
  CHECK(parameters.sched_priority == (counts.settled == 1 ? 3 : 0));
}
