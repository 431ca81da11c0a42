// SPDX-License-Identifier: Apache-2.0
#include "net/update_target.hpp"

#include <catch2/catch.hpp>

#include "tests/support/slot_machine.hpp"

using namespace g3d;
using namespace g3d::net;
using hal::Slot;
using hal::SlotBook;
using hal::SlotCondition;
using test::SlotMachine;

namespace {

hal::SlotImageId image_with(std::uint64_t release, std::uint8_t content) {
  hal::SlotImageId image{release, 100, {}};
  image.digest.fill(content);
  return image;
}

}  // namespace

TEST_CASE("which updates are taken", "[update]") {
  SlotBook book = hal::first_book(image_with(5, 5));
  const auto judge = [&](const hal::SlotImageId& image, bool force = false) {
    return judge_update(book, Slot::a, image, force);
  };
  CHECK(judge(image_with(6, 6)) == std::nullopt);
  CHECK(judge(image_with(5, 5)) == UpdateEnd::already_there);
  CHECK(judge(image_with(5, 5), true) == std::nullopt);
  CHECK(judge(image_with(5, 6)) == UpdateEnd::not_newer);
  CHECK(judge(image_with(4, 4)) == UpdateEnd::not_newer);
  CHECK(judge(image_with(4, 4), true) == std::nullopt);

  book = hal::finish_writing(hal::begin_writing(book, Slot::a, Slot::b).value(), Slot::b, image_with(7, 7), false);
  CHECK(judge(image_with(7, 7)) == UpdateEnd::already_there);  // waits for the restart
  CHECK(judge(image_with(6, 6)) == std::nullopt);              // a better thought, before any restart

  // B runs, but has not shown yet that it comes up: A is all there is to go back to, force or not.
  CHECK(judge_update(book, Slot::b, image_with(9, 9), false) == UpdateEnd::not_now);
  CHECK(judge_update(book, Slot::b, image_with(9, 9), true) == UpdateEnd::not_now);
  CHECK(judge_update(book, std::nullopt, image_with(9, 9), false) == std::nullopt);

  for (int i = 0; i <= hal::kMostFailedStarts; ++i) book = hal::plan_start(book)->book;
  REQUIRE(book[Slot::b].condition == SlotCondition::bad);
  CHECK(judge(image_with(7, 7)) == UpdateEnd::failed_before);
  CHECK(judge(image_with(8, 7)) == UpdateEnd::failed_before);  // the number is new, the bytes are not
  CHECK(judge(image_with(7, 7), true) == std::nullopt);
  CHECK(judge(image_with(8, 8)) == std::nullopt);
  CHECK(judge_update(hal::lost_book(), std::nullopt, image_with(1, 1), false) == std::nullopt);
}

TEST_CASE("an update is written into the slot that does not run", "[update]") {
  SlotMachine machine;
  const auto manifest = machine.make_image(100'000, 6);
  UpdateTarget target(machine.paths());
  CHECK(target.standing().running_release == 5);
  CHECK(target.standing().newest_good_release == 5);
  REQUIRE_FALSE(target.begin(manifest.image, false));
  CHECK(machine.book()[Slot::b].condition == SlotCondition::empty);
  const auto bytes = test::system_image(100'000, 6);
  REQUIRE_FALSE(target.write(0, bytes));
  REQUIRE_FALSE(target.sync());
  std::vector<std::uint8_t> back(1000);
  CHECK(target.read(99'000, back));
  CHECK_FALSE(target.read(99'001, back));
  machine.check_runs_on();
  CHECK(machine.book().preferred == Slot::a);
  REQUIRE_FALSE(target.finish(manifest.image, false));
  machine.check_installed(manifest);
}

TEST_CASE("a slot that somebody else has filled in the meantime is not claimed", "[update]") {
  SlotMachine machine;
  const auto manifest = machine.make_image(10, 6);
  UpdateTarget target(machine.paths());
  REQUIRE_FALSE(target.begin(manifest.image, false));
  hal::SlotStore store(machine.book_path());
  const hal::SlotImageId foreign = image_with(9, 9);
  REQUIRE(store
              .change([&](SlotBook book) -> hal::Result<SlotBook> {
                return hal::finish_writing(book, Slot::b, foreign, false);
              })
              .ok());
  CHECK(target.finish(manifest.image, false) == UpdateEnd::disk_error);
  CHECK_THAT(target.trouble(), Catch::Contains("another one"));
  CHECK(machine.book()[Slot::b].image == foreign);
}

TEST_CASE("a disk that cannot take an update leaves what runs", "[update]") {
  SlotMachine machine;
  auto paths = machine.paths();
  paths.slots[1] = machine.folder.path() + "/none/b.img";
  UpdateTarget nowhere(paths);
  CHECK(nowhere.begin(machine.make_image(10, 6).image, false) == UpdateEnd::disk_error);
  CHECK_THAT(nowhere.trouble(), Catch::Contains("none/b.img"));
  UpdateTarget full(machine.paths());
  hal::SlotImageId huge = image_with(6, 6);
  huge.size_bytes = std::uint64_t{1} << 60;
  const auto end = full.begin(huge, false);
  CHECK((end == UpdateEnd::disk_full || end == UpdateEnd::too_large));
  machine.check_runs_on();
  CHECK(hal::plan_start(machine.book())->slot == Slot::a);
  UpdateTarget lost({machine.folder.path() + "/none/book", paths.slots, Slot::a});
  CHECK(lost.standing() == UpdateGreeting{});
  CHECK(lost.begin(machine.make_image(10, 6).image, false) == UpdateEnd::disk_error);
}
