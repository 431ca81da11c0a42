// SPDX-License-Identifier: Apache-2.0
// Runs the tests. The last line is `N passed, N failed`, counted in test cases; a run without any test is a failure.
#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>
#include <cstdio>

namespace {

Catch::Counts test_cases;
bool run_ended = false;

struct CountingListener : Catch::TestEventListenerBase {
  using TestEventListenerBase::TestEventListenerBase;
  void testRunEnded(const Catch::TestRunStats& stats) override {
    test_cases = stats.totals.testCases;
    run_ended = true;
  }
};

}  // namespace

CATCH_REGISTER_LISTENER(CountingListener)

int main(int argc, char** argv) {
  const int result = Catch::Session().run(argc, argv);
  if (!run_ended) return result;  // --help, --list-tests or a bad option
  std::printf("%zu passed, %zu failed\n", test_cases.passed + test_cases.failedButOk, test_cases.failed);
  return result != 0 || test_cases.total() == 0 ? 1 : 0;
}

// OpenNI2 keeps a little for each time that it is started and for each file that it plays; what is ours must not leak.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:oni_file::\nleak:oni::implementation::\nleak:FreenectDriver::\nleak:freenect_\nleak:xnOS\n";
}
extern "C" const char* __lsan_default_options();
extern "C" const char* __lsan_default_options() { return "print_suppressions=0"; }
