// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/caretaker.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <functional>
#include <mutex>

using namespace g3d::hal;

namespace {

constexpr TimeNs kMsT = 1'000'000;

class CountingDog final : public Watchdog {
 public:
  bool feed() override {
    ++feeds;
    return true;
  }
  void disarm() override { ++disarms; }
  std::atomic<int> feeds{0}, disarms{0};
};

bool comes_true(const std::function<bool()>& condition) {
  RealClock clock;
  for (const TimeNs end_ns = clock.now() + 10'000 * kMsT; clock.now() < end_ns;) {
    if (condition()) return true;
    clock.sleep_until(clock.now() + 2 * kMsT);
  }
  return condition();
}

struct Household {
  Household() {
    CaretakerOptions options;
    options.period_ns = 5 * kMsT;
    options.feed_ns = 10 * kMsT;
    options.on_all_alive = [this] { ++alive; };
    options.on_late = [this](const std::string& name, TimeNs) {
      const std::lock_guard lock(mutex);
      said += name.empty() ? "well;" : name + ";";
    };
    options.chores.emplace_back([this](TimeNs) { ++chores; });
    worker = &board.add("worker", 200 * kMsT);
    caretaker = std::make_unique<Caretaker>(board, clock, options, &dog);
    thread = std::thread([this] {
      while (!ending.load()) {
        if (!hangs.load()) worker->tick();
        clock.sleep_until(clock.now() + 5 * kMsT);
      }
      worker->rest();
    });
  }
  ~Household() {
    ending.store(true);
    thread.join();
  }
  std::string heard() {
    const std::lock_guard lock(mutex);
    return said;
  }
  RealClock clock;
  ProgressBoard board;
  CountingDog dog;
  ProgressEntry* worker = nullptr;
  std::atomic<bool> hangs{false}, ending{false};
  std::atomic<int> alive{0}, chores{0};
  std::mutex mutex;
  std::string said;
  std::unique_ptr<Caretaker> caretaker;
  std::thread thread;
};

}  // namespace

TEST_CASE("The watchdog is fed while all make progress, and not while one hangs", "[watchdog][threads]") {
  Household house;
  house.caretaker->start();
  REQUIRE(comes_true([&] { return house.dog.feeds >= 5 && house.alive >= 5; }));
  CHECK(house.heard().find("worker") == std::string::npos);
  house.hangs.store(true);
  REQUIRE(comes_true([&] { return house.heard().ends_with("worker;"); }));
  // At most the one that was under way when it was said.
  const int fed = house.dog.feeds, told = house.alive;
  house.clock.sleep_until(house.clock.now() + 200 * kMsT);
  CHECK(house.dog.feeds <= fed + 1);
  CHECK(house.alive <= told + 1);
  CaretakerCounts counts;
  REQUIRE(house.caretaker->counts().read(counts) > 0);
  CHECK(counts.withheld > 0);
  house.hangs.store(false);
  REQUIRE(comes_true([&] { return house.dog.feeds > fed + 3; }));
  CHECK(house.heard().find("worker;well;") != std::string::npos);
  CHECK(house.chores > 10);
  CHECK(house.dog.disarms == 0);
  house.caretaker->stop();
  CHECK(house.dog.disarms == 1);
}

TEST_CASE("A caretaker that just goes leaves the watchdog armed", "[watchdog][threads]") {
  Household house;
  house.caretaker->start();
  REQUIRE(comes_true([&] { return house.dog.feeds > 0; }));
  house.caretaker.reset();
  CHECK(house.dog.disarms == 0);
}
