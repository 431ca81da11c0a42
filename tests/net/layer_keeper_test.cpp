// SPDX-License-Identifier: Apache-2.0
#include "net/layer_keeper.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <thread>
#include <utility>

#include "hal/disk.hpp"
#include "net/own_layer.hpp"
#include "tests/support/sample_maps.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using mapper::Bytes;
using net::Lane;
using net::LayerIndex;
using net::LayerKeeper;
using net::LayerStore;
using net::Version;

namespace {

constexpr hal::TimeNs kKeeperMs_ns = 1'000'000;
constexpr net::StoreLimits kKeeperStore{8, 4000, 1 << 20};

net::KeeperOptions keeper_options(const std::string& folder, bool has_thread = false) {
  net::KeeperOptions options;
  options.folder = folder;
  options.robot = 7;
  options.has_thread = has_thread;
  options.ring_bytes = 1 << 20;
  options.reserve = 1000;
  return options;
}

/// A robot of which only the store, the keeper and the counter are there.
struct KeptRobot {
  explicit KeptRobot(const net::KeeperOptions& options, const net::StoreLimits& limits = kKeeperStore)
      : store(limits),
        keeper(std::move(LayerKeeper::open(options, store)).value()),
        own(store, keeper->self(), keeper->restored_upto()) {
    own.set_limit(keeper->version_limit());
  }
  bool publish(std::uint64_t block, std::size_t bytes = 30) {
    if (!own.may_publish()) return false;
    const Version version = own.version() + 1;
    const Bytes payload(bytes, static_cast<std::uint8_t>(version));
    if (store.put(own.index(), net::block_record(2, block, net::Part::whole), version, static_cast<Lane>(version % 3),
                  payload) != LayerStore::Put::stored) {
      return false;
    }
    own.advance();
    return true;
  }
  void hear(std::uint64_t robot, std::uint64_t block, Version version) {
    const LayerIndex layer = store.find_or_add({robot, 1});
    (void)store.put(layer, net::block_record(0, block, net::Part::whole), version, Lane::rest, Bytes(20, 1));
    (void)store.add_had(layer, Lane::rest, {0, version});
  }
  void pass(hal::TimeNs duration_ns) {
    own.commit();
    for (const hal::TimeNs end_ns = now_ns + duration_ns; now_ns < end_ns;) {
      now_ns += 10 * kKeeperMs_ns;
      keeper->on_time(own.version(), now_ns);
      own.set_limit(keeper->version_limit());
    }
  }
  LayerStore store;
  std::unique_ptr<LayerKeeper> keeper;
  net::OwnLayer own;
  hal::TimeNs now_ns = 1'000'000'000;
};

/// A disk that can be full, or stuck.
struct KeeperDisk final : hal::Disk {
  [[nodiscard]] ssize_t write(int fd, const void* data, std::size_t size_bytes) override {
    while (is_stuck) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    errno = ENOSPC;
    return is_full ? -1 : Disk::write(fd, data, size_bytes);
  }
  std::atomic<bool> is_full{false};
  std::atomic<bool> is_stuck{false};
};

}  // namespace

TEST_CASE("what a robot knew when it was switched off it knows when it comes back", "[net][keeper][threads]") {
  const test::TempFolder folder;
  std::uint64_t digest = 0;
  net::LayerId self;
  Version version = 0;
  for (int start = 0; start < 4; ++start) {
    KeptRobot robot(keeper_options(folder / "a/b", true));
    if (start > 0) {
      CHECK(robot.store.digest() == digest);
      CHECK(robot.keeper->self() == self);
      CHECK(robot.keeper->restored_upto() == version);
      CHECK(robot.keeper->first_submap() == 3);
      CHECK_FALSE(robot.own.has_gap());
      CHECK(robot.store.had(robot.store.find({9, 1}), Lane::rest).upto() == static_cast<Version>(100 * start));
      CHECK(robot.store.is_unclaimed(robot.store.find({8, 1})) == (start % 2 == 1));
    }
    for (std::uint64_t i = 0; i < 100; ++i) {
      REQUIRE(robot.publish(i % 40 + static_cast<std::uint64_t>(start)));
      robot.hear(9, i, static_cast<Version>(start) * 100 + i + 1);
    }
    robot.hear(8, 1, 1);
    robot.store.set_unclaimed(robot.store.find({8, 1}), start % 2 == 0);
    robot.pass(300 * kKeeperMs_ns);
    CHECK(robot.keeper->is_durable());
    digest = robot.store.digest();
    self = robot.keeper->self();
    version = robot.own.version();
    robot.keeper->close(version);
  }
  CHECK(version == 400);
}

TEST_CASE("a robot that fell down goes on above every version that it may have used", "[net][keeper]") {
  const test::TempFolder folder;
  Version used = 0;
  net::LayerId self;
  for (int start = 0; start < 6; ++start) {
    KeptRobot robot(keeper_options(folder / "k"));
    if (start == 0) self = robot.keeper->self();
    CHECK(robot.keeper->self() == self);
    CHECK((start == 0 || robot.keeper->restored_upto() >= used));
    CHECK(robot.own.has_gap() == (start > 0));
    // Of the last start's 30 the first 20 were synced, the others never left the ring.
    CHECK(robot.store.record_count() == static_cast<std::uint32_t>(20 * start));
    for (std::uint64_t i = 0; i < 20; ++i) REQUIRE(robot.publish(1000 * static_cast<std::uint64_t>(start) + i));
    robot.pass(1000 * kKeeperMs_ns);
    for (std::uint64_t i = 20; i < 30; ++i) REQUIRE(robot.publish(1000 * static_cast<std::uint64_t>(start) + i));
    used = robot.own.version();
  }
}

TEST_CASE("versions beyond what the disk has reserved are not used", "[net][keeper]") {
  const test::TempFolder folder;
  KeeperDisk disk;
  const hal::DiskInstead instead(disk);
  net::KeeperOptions options = keeper_options(folder / "k");
  {
    KeptRobot robot(options);
    disk.is_full = true;
    int published = 0;
    for (; published < 5000 && robot.publish(static_cast<std::uint64_t>(published % 500)); ++published) {
      if (published % 50 == 0) robot.pass(1500 * kKeeperMs_ns);
    }
    CHECK(published == 1000);
    CHECK(robot.keeper->trouble().has_value());
    CHECK(robot.keeper->trouble()->reason == hal::Reason::disk_full);
    disk.is_full = false;
    robot.pass(3000 * kKeeperMs_ns);
    for (; published < 5000 && robot.publish(static_cast<std::uint64_t>(published % 500)); ++published) {
      if (published % 50 == 0) robot.pass(200 * kKeeperMs_ns);
    }
    CHECK(published == 5000);
  }
  const KeptRobot again(options);
  CHECK(again.keeper->restored_upto() >= 5000);
}

TEST_CASE("without a counter of its own a robot begins a new incarnation, and keeps what it knew", "[net][keeper]") {
  const test::TempFolder folder;
  const std::string path = folder / "k";
  std::vector<net::LayerId> selves;
  for (int start = 0; start < 4; ++start) {
    if (start == 1) std::filesystem::remove(path + "/identity");
    if (start == 2) test::write_plain(path + "/identity", std::string_view("g3dmap layer 1\nrobot 7\n"));
    net::KeeperOptions options = keeper_options(path);
    if (start == 3) options.robot = 8;
    KeptRobot robot(options);
    CHECK(std::find(selves.begin(), selves.end(), robot.keeper->self()) == selves.end());
    CHECK(robot.keeper->self().robot == options.robot);
    CHECK(robot.keeper->restored_upto() == 0);
    for (const net::LayerId& before : selves) {
      const LayerIndex layer = robot.store.find(before);
      REQUIRE(layer != net::kNoLayer);
      CHECK(robot.store.record_count(layer) == 5);
      CHECK(robot.store.upto(layer)[0] == 5);
    }
    selves.push_back(robot.keeper->self());
    for (std::uint64_t i = 0; i < 5; ++i) REQUIRE(robot.publish(i));
    robot.pass(200 * kKeeperMs_ns);
  }
}

TEST_CASE("a full disk and a stuck one cost nothing but what falls into their time", "[net][keeper][threads]") {
  const test::TempFolder folder;
  KeeperDisk disk;
  const hal::DiskInstead instead(disk);
  net::KeeperOptions options = keeper_options(folder / "k", true);
  options.ring_bytes = 1 << 16;
  const bool is_stuck = GENERATE(false, true);
  std::uint64_t digest = 0;
  {
    KeptRobot robot(options);
    for (std::uint64_t i = 0; i < 100; ++i) robot.hear(9, i, i + 1);
    robot.pass(200 * kKeeperMs_ns);
    (is_stuck ? disk.is_stuck : disk.is_full) = true;
    for (std::uint64_t i = 0; i < 1500; ++i) {
      robot.hear(9, i, 101 + i);
      if (i % 100 == 0) robot.pass(100 * kKeeperMs_ns);
    }
    if (is_stuck) CHECK(robot.keeper->counts().dropped_entries > 0);
    disk.is_stuck = false;
    disk.is_full = false;
    robot.hear(9, 1, 2000);
    // A disk takes real time, and other programs may keep it busy.
    for (int i = 0; i < 20000 && (i < 20 || !robot.keeper->is_durable()); ++i) {
      robot.pass(100 * kKeeperMs_ns);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    CHECK(robot.keeper->is_durable());
    CHECK(robot.keeper->counts().journal.new_journals > 0);
    robot.pass(200 * kKeeperMs_ns);
    digest = robot.store.digest();
  }
  const KeptRobot again(options);
  CHECK(again.store.digest() == digest);
  CHECK(again.store.had(again.store.find({9, 1}), Lane::rest).upto() == 2000);
}

TEST_CASE("a journal is made anew when most of it is old, and is never much longer than what stands", "[net][keeper]") {
  const test::TempFolder folder;
  net::KeeperOptions options = keeper_options(folder / "k");
  options.reserve = 1 << 20;
  std::uint64_t digest = 0;
  std::uint64_t most_bytes = 0;
  {
    KeptRobot robot(options);
    for (std::uint64_t i = 0; i < 20000; ++i) {
      REQUIRE(robot.publish(i % 1000, 300));
      if (i % 100 != 0) continue;
      robot.pass(100 * kKeeperMs_ns);
      std::uint64_t bytes = 0;
      for (const auto& entry : std::filesystem::directory_iterator(options.folder)) bytes += entry.file_size();
      most_bytes = std::max(most_bytes, bytes);
    }
    robot.pass(200 * kKeeperMs_ns);
    CHECK(robot.keeper->counts().journal.new_journals >= 2);
    digest = robot.store.digest();
  }
  // 1000 records of 320 bytes stand: twice that and a megabyte, and the new one beside.
  CHECK(most_bytes < (1 << 20) + 3 * 320'000 + 200'000);
  const KeptRobot again(options);
  CHECK(again.store.digest() == digest);
}

TEST_CASE("layers of a dropped robot are gone from the disk as well", "[net][keeper]") {
  const test::TempFolder folder;
  net::KeeperOptions options = keeper_options(folder / "k");
  {
    KeptRobot robot(options);
    for (std::uint64_t i = 0; i < 50; ++i) robot.hear(9, i, i + 1);
    robot.hear(8, 1, 1);
    robot.pass(200 * kKeeperMs_ns);
    REQUIRE(robot.store.refuse_robot(9));
    robot.pass(3000 * kKeeperMs_ns);
    CHECK(robot.keeper->counts().journal.new_journals == 1);
  }
  {
    // Nothing of it is there even for one who would take it.
    const KeptRobot again(options);
    CHECK(again.store.find({9, 1}) == net::kNoLayer);
    CHECK(again.store.find({8, 1}) != net::kNoLayer);
  }
  options.dropped = {8};
  {
    KeptRobot again(options);
    CHECK(again.store.find({8, 1}) == net::kNoLayer);
    CHECK(again.store.find_or_add({8, 1}) == net::kNoLayer);
  }
  options.dropped = {8, 7};
  LayerStore store(kKeeperStore);
  const auto own = LayerKeeper::open(options, store);
  REQUIRE_FALSE(own.ok());
  CHECK(own.error().reason == hal::Reason::bad_usage);
}

TEST_CASE("two robots do not keep their layers in one folder", "[net][keeper]") {
  const test::TempFolder folder;
  const KeptRobot robot(keeper_options(folder / "k"));
  LayerStore store(kKeeperStore);
  const auto second = LayerKeeper::open(keeper_options(folder / "k"), store);
  REQUIRE_FALSE(second.ok());
  CHECK(second.error().reason == hal::Reason::no_permission);
  CHECK(second.error().text.find("folder of its own") != std::string::npos);
}

TEST_CASE("a journal that cannot be read is put aside, not written over", "[net][keeper]") {
  const test::TempFolder folder;
  test::write_plain(folder / "k/layers.journal", std::string_view("something else altogether"));
  {
    KeptRobot robot(keeper_options(folder / "k"));
    REQUIRE(robot.publish(1));
    robot.pass(500 * kKeeperMs_ns);
    CHECK(robot.keeper->is_durable());
  }
  CHECK(test::read_plain(folder / "k/layers.journal.unread") == "something else altogether");
  const KeptRobot again(keeper_options(folder / "k"));
  CHECK(again.store.record_count() == 1);
}

namespace {

/// Publishes as fast as real time lets it until it is killed; says through a pipe what it has published and when.
[[noreturn]] void publish_until_killed(const std::string& folder, int pipe_fd) {
  net::KeeperOptions options = keeper_options(folder, true);
  options.reserve = 1 << 20;
  KeptRobot robot(options);
  const auto begun = std::chrono::steady_clock::now();
  for (std::uint64_t i = 0;; ++i) {
    if (!robot.publish(i % 3000)) std::_Exit(1);
    robot.own.commit();
    const Version version = robot.own.version();
    if (::write(pipe_fd, &version, sizeof version) != sizeof version) std::_Exit(1);
    robot.keeper->on_time(version, std::chrono::nanoseconds(std::chrono::steady_clock::now() - begun).count());
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
}

/// Lets it live for so long. Of what it had published a second before, nothing may be missing; no version comes twice.
void check_killed(const std::string& folder, std::chrono::milliseconds life, Version& used) {
  int ends[2];
  REQUIRE(::pipe(ends) == 0);
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(ends[0]);
    publish_until_killed(folder, ends[1]);
  }
  ::close(ends[1]);
  std::vector<std::pair<Version, std::chrono::steady_clock::time_point>> published;
  std::chrono::steady_clock::time_point first{};
  Version version = 0;
  bool is_killed = false;
  while (::read(ends[0], &version, sizeof version) == sizeof version) {
    const auto now = std::chrono::steady_clock::now();
    if (published.empty()) {
      first = now;
      REQUIRE(version > used);
    }
    published.emplace_back(version, now);
    if (is_killed || now - first < life) continue;
    REQUIRE(::kill(child, SIGKILL) == 0);
    is_killed = true;
  }
  ::close(ends[0]);
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  REQUIRE(WIFSIGNALED(status));
  const auto end = published.back().second;
  const KeptRobot again(keeper_options(folder));
  CHECK(again.keeper->restored_upto() >= published.back().first);
  Version kept = 0;
  again.store.for_each(again.own.index(),
                       [&](const net::StoredRecord& record) { kept = std::max(kept, record.version); });
  for (const auto& [each, when] : published) {
    if (end - when > std::chrono::seconds(1)) CHECK(kept >= each);
  }
  // A prefix: nothing between is missing, but for what came in its place.
  std::uint32_t standing = 0;
  again.store.for_each(again.own.index(), [&](const net::StoredRecord& record) {
    if (record.version >= published.front().first) ++standing;
  });
  if (kept >= published.front().first) {
    CHECK(standing == std::min<Version>(kept - published.front().first + 1, 3000));
  }
  used = again.keeper->restored_upto();
}

}  // namespace

TEST_CASE("a robot that is killed at any moment keeps what it knew, and gives no version twice", "[net][keeper]") {
  const test::TempFolder folder;
  Version used = 0;
  for (const int life_ms : {0, 3, 40, 170}) check_killed(folder / "k", std::chrono::milliseconds(life_ms), used);
}

TEST_CASE("a robot that is killed loses the last second at most", "[net][keeper][slow]") {
  const test::TempFolder folder;
  tests::Random random(21);
  Version used = 0;
  for (int i = 0; i < 5; ++i) check_killed(folder / "k", std::chrono::milliseconds(1100 + random.below(700)), used);
}
