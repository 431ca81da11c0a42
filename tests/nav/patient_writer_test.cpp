// SPDX-License-Identifier: Apache-2.0
#include "nav/patient_writer.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "hal/image/file_bytes.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using nav::OutputJob;
using nav::Outputs;

namespace {

/// Time passes only while somebody sleeps.
class SleepClock final : public hal::Clock {
 public:
  [[nodiscard]] hal::TimeNs now() const override { return now_ns; }
  void sleep_until(hal::TimeNs t_ns) override { now_ns = std::max(now_ns, t_ns); }
  hal::TimeNs now_ns = 0;
};

struct Bench {
  SleepClock clock;
  std::vector<std::string> tried;
  int told = 0;

  /// Fails for so many tries, for that reason.
  OutputJob job(const std::string& name, int failures, hal::Reason reason = hal::Reason::disk_full) {
    return {"out/" + name, [this, name, failures, reason, tries = 0]() mutable -> hal::Result<mapper::WrittenFile> {
              tried.push_back(name);
              if (++tries <= failures) return hal::Error{reason, name + ": no"};
              return mapper::WrittenFile{"out/" + name, "a file", 7};
            }};
  }
  nav::Patience patience(double seconds) {
    nav::Patience p;
    p.seconds = seconds;
    p.clock = &clock;
    p.on_wait = [this](const hal::Error&) { ++told; };
    return p;
  }
};

}  // namespace

TEST_CASE("without patience every file is tried once") {
  Bench bench;
  const Outputs outputs = nav::write_patiently({bench.job("a", 0), bench.job("b", 1), bench.job("c", 0)});
  CHECK(bench.tried == std::vector<std::string>{"a", "b", "c"});
  CHECK(outputs.files.size() == 2);
  REQUIRE(outputs.failures.size() == 1);
  CHECK(outputs.failures[0].text == "b: no");
  CHECK(outputs.late_files == 0);
}

TEST_CASE("what failed is tried again each second, the rest is not, and the order stays") {
  Bench bench;
  const Outputs outputs =
      nav::write_patiently({bench.job("a", 2), bench.job("map.g3d", 1), bench.job("c", 0)}, bench.patience(30.0));
  CHECK(bench.tried == std::vector<std::string>{"a", "map.g3d", "c", "a", "map.g3d", "a"});
  REQUIRE(outputs.files.size() == 3);
  CHECK(outputs.files[0].path == "out/a");
  CHECK(outputs.map_file_bytes == 7);
  CHECK(outputs.late_files == 2);
  CHECK(outputs.failures.empty());
  CHECK(bench.told == 1);
  CHECK(bench.clock.now_ns == 2'000'000'000);
}

TEST_CASE("patience ends, or is ended by a person") {
  Bench bench;
  CHECK(nav::write_patiently({bench.job("a", 100)}, bench.patience(3.0)).failures.size() == 1);
  CHECK(bench.tried.size() == 4);
  Bench given_up;
  nav::Patience patience = given_up.patience(1000.0);
  patience.is_given_up = [&] { return given_up.clock.now_ns > 1'500'000'000; };
  CHECK(nav::write_patiently({given_up.job("a", 10'000)}, patience).failures.size() == 1);
  CHECK(given_up.clock.now_ns < 2'000'000'000);
}

TEST_CASE("what no patience helps is tried once") {
  for (const hal::Reason reason : {hal::Reason::unsupported, hal::Reason::too_large, hal::Reason::out_of_range}) {
    Bench bench;
    CHECK(nav::write_patiently({bench.job("a", 1, reason)}, bench.patience(30.0)).failures.size() == 1);
    CHECK(bench.clock.now_ns == 0);
    CHECK(bench.told == 0);
  }
}

TEST_CASE("a folder that was taken away is made again") {
  Bench bench;
  const test::TempFolder folder;
  const std::string path = folder.path() + "/out/report.json";
  const auto write = [&]() -> hal::Result<mapper::WrittenFile> {
    if (const auto written = hal::write_file_atomic(path, std::string("{}")); !written) return written.error();
    return mapper::WrittenFile{path, "what happened", 2};
  };
  CHECK(nav::write_patiently({{path, write}}, bench.patience(5.0)).failures.empty());
  CHECK(std::filesystem::file_size(path) == 2);
}
