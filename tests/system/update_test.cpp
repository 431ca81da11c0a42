// SPDX-License-Identifier: Apache-2.0
// `g3dmap update` and `g3dmap slots` as they are typed: a key is made, one program takes updates, another one sends
// them.
#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <fstream>
#include <string>
#include <thread>

#include "tests/support/run_program.hpp"
#include "tests/support/slot_machine.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::test;
using Catch::Contains;

namespace {

/// The program that takes updates for a folder with slots in it, and where it listens.
class Taker {
 public:
  Taker(const TempFolder& folder, const std::string& trust, const std::string& running)
      : log_(empty_file(folder / ("taker-" + running + ".log"))),
        program_("/bin/sh", {"-c", "exec \"$0\" \"$@\" 2>" + log_, g3dmap_path(), "update", "--listen", "127.0.0.1:0",
                             "--trust", trust, "--state", folder / "slots", "--slot-a", folder / "a.img", "--slot-b",
                             folder / "b.img", "--running", running, "--rate-kBps", "1000000"}) {
    const std::string mark = "listening at ";
    for (int i = 0; i < 400; ++i) {
      const std::string log = read_plain(log_);
      const std::size_t at = log.find(mark), end = log.find(" for", at);
      if (at != std::string::npos && end != std::string::npos) {
        at_ = log.substr(at + mark.size(), end - at - mark.size());
        return;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(25));
    }
    FAIL("nothing listens: " << read_plain(log_));
  }
  [[nodiscard]] const std::string& at() const { return at_; }
  [[nodiscard]] std::string log() const { return read_plain(log_); }
  Program& program() { return program_; }

 private:
  static std::string empty_file(const std::string& path) {
    write_plain(path, "");
    return path;
  }
  std::string log_;
  Program program_;
  std::string at_;
};

}  // namespace

TEST_CASE("a system goes from one machine into the slot of another", "[system][update]") {
  const TempFolder folder;
  const std::string key = folder / "owner.key", first = folder / "a.img", second = folder / "second.img",
                    book = folder / "slots";
  const ProgramResult made = run_g3dmap({"update", "--new-key", key});
  INFO(made.err);
  REQUIRE(made.exit_code == 0);
  CHECK(run_g3dmap({"update", "--new-key", key}).exit_code == 1);
  write_plain(first, system_image(100'000, 1));
  write_plain(second, system_image(3'000'000, 2));
  REQUIRE(run_g3dmap({"slots", "--state", book, "--first", first, "--release", "1"}).exit_code == 0);

  {
    Taker taker(folder, key + ".pub", "a");
    const std::string stranger = folder / "stranger.key";
    REQUIRE(run_g3dmap({"update", "--new-key", stranger}).exit_code == 0);
    const ProgramResult refused = run_g3dmap({"update", "--key", stranger, "--to", taker.at(), second});
    CHECK(refused.exit_code == 1);
    CHECK_THAT(refused.err, Contains("does not trust this signing key"));
    const ProgramResult older = run_g3dmap({"update", "--key", key, "--to", taker.at(), "--release", "1", second});
    CHECK(older.exit_code == 1);
    CHECK_THAT(older.err, Contains("--force"));
    const ProgramResult sent = run_g3dmap({"update", "--key", key, "--to", taker.at(), "--release", "2", second});
    INFO(sent.err << taker.log());
    REQUIRE(sent.exit_code == 0);
    CHECK_THAT(sent.out, Contains("release 2: installed") && Contains("46 of 46 chunks"));
    CHECK(taker.program().finish().exit_code == 0);
    CHECK_THAT(taker.log(), Contains("wrong key") && Contains("not newer") && Contains("installed; restart"));
  }
  CHECK(read_plain(folder / "b.img") == read_plain(second));
  const ProgramResult slots = run_g3dmap({"slots", "--state", book});
  CHECK_THAT(slots.out, Contains("slot a: good, release 1, 100000 bytes") &&
                            Contains("slot b: untried, release 2, 3000000 bytes") && Contains("next: b"));
  CHECK_THAT(
      run_g3dmap({"slots", "--state", book, "--json"}).out,
      Contains(
          R"({"next": "b", "newest_good_release": 1, "a": {"condition": "good", "release": 1, "bytes": 100000, "starts": 0})"));

  // B has been started, but has not shown yet that it comes up.
  REQUIRE(hal::choose_slot(*std::make_unique<hal::SlotStore>(book)).slot == hal::Slot::b);
  Taker untried(folder, key + ".pub", "b");
  const ProgramResult early = run_g3dmap({"update", "--key", key, "--to", untried.at(), "--release", "3", first});
  CHECK(early.exit_code == 1);
  CHECK_THAT(early.err, Contains("has not been healthy for long enough"));
  untried.program().send(SIGTERM);
  CHECK(untried.program().finish().exit_code == 1);
  CHECK(read_plain(first) == std::string(reinterpret_cast<const char*>(system_image(100'000, 1).data()), 100'000));
}

TEST_CASE("what is wrong with an update command is said before anything is done", "[system][update]") {
  const TempFolder folder;
  const std::string key = folder / "owner.key", image = folder / "system.img";
  REQUIRE(run_g3dmap({"update", "--new-key", key}).exit_code == 0);
  write_plain(image, "x");
  CHECK(run_g3dmap({"update"}).exit_code == 2);
  CHECK(run_g3dmap({"update", "--to", "10.0.0.2", "--new-key", "x"}).exit_code == 2);
  CHECK(run_g3dmap({"update", "--to", "10.0.0.2", "--key", key}).exit_code == 2);
  for (const char* to : {"robot.local", "10.0.0.2:0", "10.0.0.2:x", "10.0.0.2:70000", ":7178", "7178"}) {
    CHECK(run_g3dmap({"update", "--to", to, "--key", key, image}).exit_code == 2);
  }
  CHECK(run_g3dmap({"update", "--listen", "7178"}).exit_code == 2);
  CHECK(run_g3dmap({"update", "--listen", "x", "--trust", key}).exit_code == 2);
  const auto fails = [&](const std::vector<std::string>& arguments, const std::string& says) {
    const ProgramResult result = run_g3dmap(arguments);
    CHECK(result.exit_code == 1);
    CHECK_THAT(result.err, Contains(says));
  };
  fails({"update", "--to", "127.0.0.1:1", "--key", key, image}, "nothing listens at that port");
  fails({"update", "--to", "127.0.0.1:1", "--key", key, folder / "none"}, "is not there");
  fails({"update", "--to", "127.0.0.1:1", "--key", image, image}, "others may read");
  fails({"slots", "--state", folder / "none"}, "cannot open");
  fails({"slots", "--state", image}, "neither of its two records");
}
