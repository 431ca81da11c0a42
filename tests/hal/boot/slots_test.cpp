// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/slots.hpp"

#include <catch2/catch.hpp>
#include <deque>
#include <set>
#include <tuple>
#include <vector>

using namespace g3d;
using namespace g3d::hal;

namespace {

SlotImageId image_of(std::uint64_t release) {
  SlotImageId image{release, 1000 + release, {}};
  image.digest[0] = static_cast<std::uint8_t>(release);
  return image;
}

SlotBook updated(SlotBook book, Slot running, std::uint64_t release, bool may_go_back = false) {
  const Slot target = slot_for_update(book, running);
  const auto begun = begin_writing(book, running, target);
  REQUIRE(begun.ok());
  return finish_writing(begun.value(), target, image_of(release), may_go_back);
}

/// What lies in a slot in truth, whatever the book says.
enum class Content : std::uint8_t { half, works, broken };

/// A machine as far as slots are concerned, between two steps of which a power cut may come.
struct Machine {
  SlotBook book;
  std::array<Content, 2> contents{Content::works, Content::half};
  int running = -1;  ///< slot, or -1: off
  bool is_healthy = false;
  bool is_writing = false;

  [[nodiscard]] Content content(Slot slot) const { return contents[static_cast<std::size_t>(slot)]; }
  [[nodiscard]] auto key() const {
    std::vector<int> parts{static_cast<int>(book.preferred), running, is_healthy, is_writing};
    for (std::size_t i = 0; i < 2; ++i) {
      parts.push_back(static_cast<int>(book.entries[i].condition));
      parts.push_back(book.entries[i].starts);
      parts.push_back(static_cast<int>(contents[i]));
    }
    return parts;
  }
};

Machine switched_off(Machine machine) {
  machine.running = -1;
  machine.is_healthy = machine.is_writing = false;
  return machine;
}

/// Every state that one step leads to, the power cut before and after each write of the book included.
std::vector<Machine> steps_from(const Machine& machine) {
  std::vector<Machine> next{switched_off(machine)};
  if (machine.running < 0) {
    const auto plan = plan_start(machine.book);
    REQUIRE(plan);
    REQUIRE(machine.content(plan->slot) != Content::half);
    Machine started = machine;
    started.book = plan->book;
    next.push_back(started);  // cut after the write, before the start
    started.running = static_cast<int>(plan->slot);
    next.push_back(started);
    return next;
  }
  const auto running = static_cast<Slot>(machine.running);
  if (machine.content(running) == Content::works && !machine.is_healthy) {
    Machine healthy = machine;
    healthy.is_healthy = true;
    healthy.book = started_well(machine.book, running);
    next.push_back(healthy);
  }
  // Anybody may send an update, healthy or not.
  const Slot target = slot_for_update(machine.book, running);
  if (const auto begun = begin_writing(machine.book, running, target); begun && !machine.is_writing) {
    Machine writing = machine;
    writing.book = begun.value();
    next.push_back(writing);
    writing.is_writing = true;
    writing.contents[static_cast<std::size_t>(target)] = Content::half;
    next.push_back(writing);
  }
  if (machine.is_writing) {
    for (const Content content : {Content::works, Content::broken}) {
      Machine written = machine;
      written.contents[static_cast<std::size_t>(target)] = content;
      next.push_back(written);  // cut before the book knows
      written.is_writing = false;
      written.book = finish_writing(machine.book, target, {}, false);
      next.push_back(written);
    }
  }
  return next;
}

int starts_until_healthy(Machine machine) {
  for (int start = 1; start <= 10; ++start) {
    const auto plan = plan_start(machine.book);
    if (!plan) return 1000;
    machine.book = plan->book;
    if (machine.content(plan->slot) == Content::works) return start;
  }
  return 1000;
}

}  // namespace

TEST_CASE("a machine that was flashed starts A, for ever, and counts nothing", "[slots]") {
  SlotBook book = first_book(image_of(5));
  CHECK(book.newest_good_release == 5);
  for (int i = 0; i < 10; ++i) {
    const auto plan = plan_start(book);
    REQUIRE(plan);
    CHECK(plan->slot == Slot::a);
    CHECK(plan->book == book);
    book = plan->book;
  }
}

TEST_CASE("an update that comes up is kept; then the next one goes to the other slot", "[slots]") {
  SlotBook book = updated(first_book(image_of(5)), Slot::a, 6);
  auto plan = plan_start(book);
  REQUIRE(plan);
  CHECK(plan->slot == Slot::b);
  CHECK(plan->book[Slot::b].starts == 1);
  book = started_well(plan->book, Slot::b);
  CHECK(book[Slot::b].condition == SlotCondition::good);
  CHECK(book.newest_good_release == 6);
  CHECK(book[Slot::a].condition == SlotCondition::good);
  book = updated(book, Slot::b, 7);
  CHECK(plan_start(book)->slot == Slot::a);
}

TEST_CASE("one that does not come up is left after three starts, and never started again", "[slots]") {
  SlotBook book = updated(first_book(image_of(5)), Slot::a, 6);
  for (int i = 0; i < kMostFailedStarts; ++i) {
    const auto plan = plan_start(book);
    REQUIRE(plan);
    CHECK(plan->slot == Slot::b);
    CHECK_FALSE(plan->given_up);
    book = plan->book;
  }
  const auto plan = plan_start(book);
  REQUIRE(plan);
  CHECK(plan->slot == Slot::a);
  CHECK(plan->given_up == Slot::b);
  CHECK(plan->book[Slot::b].condition == SlotCondition::bad);
  CHECK(plan_start(plan->book)->slot == Slot::a);
  CHECK_FALSE(plan_start(plan->book)->given_up);
  CHECK(started_well(plan->book, Slot::a).newest_good_release == 5);
}

TEST_CASE("what was good once is not left for want of health", "[slots]") {
  SlotBook book = started_well(plan_start(updated(first_book(image_of(5)), Slot::a, 6))->book, Slot::b);
  for (int i = 0; i < 10; ++i) {
    const auto plan = plan_start(book);
    CHECK(plan->slot == Slot::b);
    book = plan->book;
  }
}

TEST_CASE("a slot that cannot be mounted gives way within the same boot", "[slots]") {
  const SlotBook before = updated(first_book(image_of(5)), Slot::a, 6);
  UnusableSlots unusable;
  auto plan = plan_start(before);
  REQUIRE(plan->slot == Slot::b);
  SlotBook book = cannot_start(plan->book, Slot::b);
  CHECK(book[Slot::b].condition == SlotCondition::bad);
  unusable.add(Slot::b);
  plan = plan_start(book, unusable);
  REQUIRE(plan);
  CHECK(plan->slot == Slot::a);
  book = cannot_start(plan->book, Slot::a);
  CHECK(book[Slot::a].condition == SlotCondition::untried);  // its disk may answer at the next boot
  unusable.add(Slot::a);
  CHECK_FALSE(plan_start(book, unusable));
  CHECK(plan_start(book)->slot == Slot::a);
}

TEST_CASE("what does not come up is started rather than nothing", "[slots]") {
  SlotBook book = updated(first_book(image_of(5)), Slot::a, 6);
  book[Slot::b].condition = SlotCondition::bad;
  UnusableSlots unusable;
  unusable.add(Slot::a);
  const auto plan = plan_start(book, unusable);
  REQUIRE(plan);
  CHECK(plan->slot == Slot::b);
  CHECK_FALSE(plan_start(SlotBook{}));
}

TEST_CASE("without a book both are tried in turn until one comes up", "[slots]") {
  SlotBook book = lost_book();
  std::string order;
  for (int i = 0; i < 12; ++i) {
    const auto plan = plan_start(book);
    REQUIRE(plan);
    order += to_string(plan->slot);
    book = plan->book;
    CHECK(book[Slot::a].condition == SlotCondition::untried);
    CHECK(book[Slot::b].condition == SlotCondition::untried);
  }
  CHECK(order == "aaabbbaaabbb");
  book = started_well(book, Slot::b);
  for (int i = 0; i < 4; ++i) book = plan_start(book)->book;
  CHECK(plan_start(book)->slot == Slot::b);
}

TEST_CASE("the only good system is never overwritten, nor the one that runs", "[slots]") {
  const SlotBook good = first_book(image_of(5));
  CHECK(begin_writing(good, Slot::a, Slot::a).error().reason == Reason::bad_usage);
  const SlotBook untried = plan_start(updated(good, Slot::a, 6))->book;
  CHECK(slot_for_update(untried, Slot::b) == Slot::a);
  CHECK(begin_writing(untried, Slot::b, Slot::a).error().reason == Reason::no_permission);
  CHECK(begin_writing(started_well(untried, Slot::b), Slot::b, Slot::a).ok());
  // The initramfs alone runs: the worse slot is written.
  CHECK(slot_for_update(untried, std::nullopt) == Slot::b);
  CHECK(begin_writing(untried, std::nullopt, Slot::b).ok());
  CHECK(slot_for_update(lost_book(), std::nullopt) == Slot::b);
  CHECK(begin_writing(lost_book(), Slot::a, Slot::b).ok());
}

TEST_CASE("an update that has begun leaves nothing of the slot's old word, and what runs is next", "[slots]") {
  SlotBook book = updated(first_book(image_of(5)), Slot::a, 6);
  const auto again = begin_writing(book, Slot::a, Slot::b);  // a second update, before any restart
  REQUIRE(again.ok());
  CHECK(again.value()[Slot::b] == SlotEntry{});
  CHECK(again.value().preferred == Slot::a);
  CHECK(plan_start(again.value())->slot == Slot::a);
  CHECK(started_well(again.value(), Slot::b) == again.value());  // nothing is there that could be good
}

TEST_CASE("an older release becomes the newest good one only if its sender wanted that", "[slots]") {
  const SlotBook book = first_book(image_of(9));
  CHECK(started_well(updated(book, Slot::a, 3), Slot::b).newest_good_release == 9);
  const SlotBook back = started_well(updated(book, Slot::a, 3, true), Slot::b);
  CHECK(back.newest_good_release == 3);
  CHECK(started_well(back, Slot::a).newest_good_release == 3);  // A was good before: nothing new
}

TEST_CASE("health counts when it lasts", "[slots]") {
  HealthTrial trial(1000);
  CHECK_FALSE(trial.note(0, true));
  CHECK_FALSE(trial.note(900, true));
  CHECK_FALSE(trial.note(950, false));
  CHECK_FALSE(trial.note(1000, true));
  CHECK_FALSE(trial.note(1999, true));
  CHECK(trial.note(2000, true));
  CHECK(trial.note(2001, false));
}

TEST_CASE("through all updates, cuts and failures one system that comes up is left", "[slots]") {
  Machine flashed;
  flashed.book = first_book({});
  std::set<std::vector<int>> seen{flashed.key()};
  std::deque<Machine> open{flashed};
  int rolled_back = 0;
  while (!open.empty()) {
    const Machine machine = open.front();
    open.pop_front();
    bool has_good = false;
    for (const Slot slot : {Slot::a, Slot::b}) {
      const SlotCondition condition = machine.book[slot].condition;
      if (condition == SlotCondition::good) {
        REQUIRE(machine.content(slot) == Content::works);
        has_good = true;
      }
      // A start of something half written would be a start of anything.
      if (machine.content(slot) == Content::half) REQUIRE(condition == SlotCondition::empty);
      if (condition == SlotCondition::bad) ++rolled_back;
    }
    REQUIRE(has_good);
    REQUIRE(starts_until_healthy(machine) <= kMostFailedStarts + 1);
    for (const Machine& next : steps_from(machine)) {
      if (seen.insert(next.key()).second) open.push_back(next);
    }
  }
  CHECK(rolled_back > 0);
  CHECK(seen.size() > 50);
}
