// SPDX-License-Identifier: Apache-2.0
#include "mapper/cuda/helper_starter.hpp"

#include <catch2/catch.hpp>
#include <chrono>
#include <thread>
#include <vector>

#include "tests/support/fake_card.hpp"
#include "tests/support/small_helper.hpp"

using namespace g3d;
using namespace g3d::mapper::cuda;

namespace {

constexpr hal::TimeNs kLong_ns = 20'000'000'000;

bool take_in_time(HelperStarter& starter, std::shared_ptr<HelperProcess>& helper, std::string& problem) {
  for (int i = 0; i < 20'000; ++i) {
    if (starter.take(helper, problem)) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

}  // namespace

TEST_CASE("a helper is started elsewhere while the mapper goes on, as often as it is asked for", "[threads]") {
  const test::FakeCard card(test::FakeDriver::works);
  const test::SmallSetup rig;
  HelperStarter starter(rig.setup());
  std::shared_ptr<HelperProcess> helper;
  std::string problem;
  CHECK_FALSE(starter.is_under_way());
  CHECK_FALSE(starter.take(helper, problem));
  int last_pid = -1;
  for (int i = 0; i < 3; ++i) {
    starter.ask();
    CHECK(starter.is_under_way());
    starter.ask();  // changes nothing
    REQUIRE(take_in_time(starter, helper, problem));
    REQUIRE(helper != nullptr);
    CHECK(problem.empty());
    CHECK_FALSE(starter.is_under_way());
    CHECK_FALSE(starter.take(helper, problem));
    REQUIRE(helper->wait_started(kLong_ns) == HelperState::ready);
    CHECK(helper->pid() != last_pid);
    last_pid = helper->pid();
    helper.reset();
  }
}

TEST_CASE("a helper that cannot be started is told of, and one that nobody took ends with its starter", "[threads]") {
  const test::FakeCard card(test::FakeDriver::works);
  const test::SmallSetup rig;
  HelperSetup without_program = rig.setup();
  without_program.program = {};
  std::shared_ptr<HelperProcess> helper;
  std::string problem;
  {
    HelperStarter starter(without_program);
    starter.ask();
    REQUIRE(take_in_time(starter, helper, problem));
    CHECK(helper == nullptr);
    CHECK(problem.find("clang") != std::string::npos);
  }
  for (int i = 0; i < 5; ++i) {
    HelperStarter starter(rig.setup());
    starter.ask();
    if (i > 2) std::this_thread::sleep_for(std::chrono::milliseconds(5 * i));
  }
}
