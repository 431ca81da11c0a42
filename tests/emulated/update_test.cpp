// SPDX-License-Identifier: Apache-2.0
// What a bad system does to a robot that has a good one in the other slot.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "hal/boot/slot_store.hpp"
#include "tests/emulated/robot_machine.hpp"

using namespace g3d;
using namespace g3d::test;
using std::chrono::seconds;

namespace {

/// A file system with a program that no machine can run.
std::string bad_system(const TempFolder& folder) {
  write_plain(folder / "bad/g3dmap", "this is no program\n");
  std::filesystem::permissions(folder / "bad/g3dmap", std::filesystem::perms::owner_all);
  const std::string image = folder / "bad.img";
  Program maker("/sbin/mke2fs", {"-q", "-t", "ext4", "-F", "-O", "^has_journal", "-d", folder / "bad", image, "8M"});
  if (const ProgramResult made = maker.finish(); made.exit_code != 0) FAIL(made.err);
  return image;
}

void write_into(const std::string& disk, const std::string& partition, const std::string& image) {
  std::fstream file(disk, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(static_cast<std::streamoff>(find_in_disk(disk, partition).begin_bytes));
  std::ifstream from(image, std::ios::binary);
  file << from.rdbuf();
  REQUIRE(file.good());
}

}  // namespace

TEST_CASE("a system that does not run is left for the one that did, without anybody's help", "[emulated]") {
  if (const std::string missing = no_robot_machine(); !missing.empty()) FAIL(missing);
  const TempFolder folder;
  RobotMachine robot("two_rooms");
  write_into(robot.disk(), "system-b", bad_system(folder));
  hal::SlotStore store(folder / "slots.state");
  const auto update = [](hal::SlotBook book) -> hal::Result<hal::SlotBook> {
    const auto begun = hal::begin_writing(book, hal::Slot::a, hal::Slot::b);
    if (!begun) return begun.error();
    return hal::finish_writing(begun.value(), hal::Slot::b, {2, 0, {}}, false);
  };
  REQUIRE(store.change(update, hal::first_book({1, 0, {}})).ok());
  put_on_data(robot.disk(), folder / "slots.state", "slots.state");

  Machine& machine = robot.machine();
  machine.power_on();
  const auto tried = machine.await("system b, on trial", kBootLimit);
  INFO(machine.console());
  REQUIRE(tried);
  REQUIRE(machine.await("on trial and does not run", kBootLimit));
  REQUIRE(machine.await("did not come up: back to the other one", 4 * kBootLimit));
  REQUIRE(machine.await(kMapping, kBootLimit));
  const std::string console = machine.console();
  std::size_t trials = 0;
  for (std::size_t at = 0; (at = console.find("system b, on trial", at)) != std::string::npos; ++at) ++trials;
  CHECK(trials == hal::kMostFailedStarts);
  CHECK(robot.moves_within(kMoveLimit));
}
