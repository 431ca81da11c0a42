// SPDX-License-Identifier: Apache-2.0
// The helper program itself: it belongs to whoever started it, and to nobody else.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "hal/clock.hpp"
#include "mapper/cuda/carried.hpp"
#include "tests/support/fake_card.hpp"
#include "tests/support/small_helper.hpp"

using namespace g3d;
using mapper::cuda::HelperState;

TEST_CASE("a helper that is told to end does so by itself") {
  const test::FakeCard card(test::FakeDriver::works);
  test::SmallHelper helper;
  REQUIRE(helper.started() == HelperState::ready);
  const pid_t pid = helper->pid();
  REQUIRE(helper->end(20'000'000'000));
  int status = -1;
  REQUIRE(waitpid(pid, &status, 0) == pid);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
  CHECK_FALSE(helper->import_blocks(0));
  CHECK_FALSE(helper->end(20'000'000'000));
}

TEST_CASE("a helper whose program has ended ends as well") {
  const test::FakeCard card(test::FakeDriver::works);
  int pipe_ends[2];
  REQUIRE(pipe(pipe_ends) == 0);
  const pid_t program = fork();
  if (program == 0) {
    test::SmallHelper helper;
    const pid_t pid = helper.started() == HelperState::ready ? helper->pid() : -1;
    (void)!write(pipe_ends[1], &pid, sizeof pid);
    kill(getpid(), SIGKILL);  // without a chance to tidy up
  }
  pid_t helper = -1;
  REQUIRE(read(pipe_ends[0], &helper, sizeof helper) == sizeof helper);
  REQUIRE(waitpid(program, nullptr, 0) == program);
  REQUIRE(helper > 0);
  hal::RealClock clock;
  for (int i = 0; i < 1000 && kill(helper, 0) == 0; ++i) clock.sleep_until(clock.now() + 10'000'000);
  CHECK(kill(helper, 0) != 0);
  close(pipe_ends[0]);
  close(pipe_ends[1]);
}
