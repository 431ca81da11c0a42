// SPDX-License-Identifier: Apache-2.0
// Saving must survive what disks and power switches do: kill -9 at any moment, a full disk, a read-only folder.
#include "mapper/files/map_file.hpp"

#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "mapper/map_hash.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;
namespace fs = std::filesystem;

namespace {

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "g3d_map_file_XXXXXX").string();
    REQUIRE(mkdtemp(name.data()) != nullptr);
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  [[nodiscard]] std::string operator/(const char* name) const { return (path_ / name).string(); }
  [[nodiscard]] std::string path() const { return path_.string(); }

 private:
  fs::path path_;
};

/// Runs `work` in a forked child; returns its exit status as of waitpid.
template <typename Work>
pid_t in_child(Work work) {
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) _exit(work());
  return child;
}

int kill_points() {
  const char* count = std::getenv("G3D_KILL_POINTS");
  return count != nullptr ? std::atoi(count) : 50;
}

}  // namespace

TEST_CASE("A map goes to disk and comes back") {
  const TemporaryFolder folder;
  const std::string path = folder / "map.g3d";
  const auto map = tests::random_map(41, 500);
  const auto saved = save_map(*map, {hal::from_xyz_rpy(1, 2, 3, 0, 0, 1), {4, 2}, 5}, path);
  REQUIRE(saved.ok());
  CHECK(saved.value().file_bytes == fs::file_size(path));
  const auto info = read_map_info(path);
  REQUIRE(info.ok());
  CHECK(info.value().file_bytes == fs::file_size(path));
  CHECK(info.value().counts.occupied == map->counts().occupied);
  CHECK(info.value().meta.layer_id == 5);
  const auto loaded = load_map(path);
  REQUIRE(loaded.ok());
  CHECK(tests::same_map(*map, *loaded.value().map));
}

TEST_CASE("A missing, an empty and a foreign map file each say so") {
  const TemporaryFolder folder;
  CHECK(load_map(folder / "none.g3d").error().reason == hal::Reason::not_found);
  CHECK(read_map_info(folder / "none.g3d").error().reason == hal::Reason::not_found);
  std::ofstream(folder / "empty.g3d").flush();
  CHECK_FALSE(load_map(folder / "empty.g3d").ok());
  CHECK_FALSE(read_map_info(folder / "empty.g3d").ok());
  std::ofstream(folder / "foreign.g3d") << "ply\nformat ascii 1.0\n";
  CHECK(load_map(folder / "foreign.g3d").error().text.find("not a g3d map") != std::string::npos);
}

TEST_CASE("A process killed at any moment of a save leaves the old map or the new one", "[slow]") {
  const TemporaryFolder folder;
  const std::string path = folder / "map.g3d";
  const auto old_map = tests::random_map(42, 2000);
  const auto new_map = tests::random_map(43, 2000);
  const std::string old_hash = map_hash(*old_map);
  const std::string new_hash = map_hash(*new_map);

  REQUIRE(save_map(*old_map, {}, path).ok());
  const auto begin = std::chrono::steady_clock::now();
  REQUIRE(save_map(*new_map, {}, path).ok());
  const auto duration_us =
      std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::steady_clock::now() - begin).count();

  tests::Random random(44);
  int old_found = 0;
  int new_found = 0;
  for (int i = 0; i < kill_points(); ++i) {
    REQUIRE(save_map(*old_map, {}, path).ok());
    const pid_t child = in_child([&] { return save_map(*new_map, {}, path).ok() ? 0 : 1; });
    // Up to a little past a save's own time, so that some kills come too late.
    usleep(static_cast<useconds_t>(random.below(static_cast<std::uint32_t>(duration_us + duration_us / 4 + 200))));
    kill(child, SIGKILL);
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    const auto found = load_map(path);
    REQUIRE(found.ok());
    const std::string hash = map_hash(*found.value().map);
    REQUIRE((hash == old_hash || hash == new_hash));
    ++(hash == old_hash ? old_found : new_found);
  }
  CHECK(old_found > 0);  // otherwise the kills came too late to test anything
  CHECK(old_found + new_found == kill_points());
  CHECK(save_map(*new_map, {}, path).ok());  // what the killed ones left behind is in nobody's way
}

TEST_CASE("A save beyond the file size limit fails clearly and keeps the old map") {
  const TemporaryFolder folder;
  const std::string path = folder / "map.g3d";
  const auto old_map = tests::random_map(45, 20);
  const auto new_map = tests::random_map(46, 3000);
  REQUIRE(save_map(*old_map, {}, path).ok());
  const pid_t child = in_child([&] {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{20000, 20000};
    setrlimit(RLIMIT_FSIZE, &limit);
    const auto done = save_map(*new_map, {}, path);
    return done.ok() ? 1 : done.error().text.find(path) == 0 ? 0 : 2;
  });
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
  const auto loaded = load_map(path);
  REQUIRE(loaded.ok());
  CHECK(tests::same_map(*old_map, *loaded.value().map));
}

TEST_CASE("A full disk fails clearly and keeps the old map") {
  const TemporaryFolder folder;
  if (mount("none", folder.path().c_str(), "tmpfs", 0, "size=256k") != 0) return;  // only root may, and not everywhere
  const std::string path = folder / "map.g3d";
  const auto old_map = tests::random_map(47, 20);
  const bool saved = save_map(*old_map, {}, path).ok();
  const auto failed = save_map(*tests::random_map(48, 4000), {}, path);
  const auto loaded = load_map(path);
  const bool only_one_file = std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()) == 1;
  umount(folder.path().c_str());
  CHECK(saved);
  REQUIRE_FALSE(failed.ok());
  CHECK(failed.error().reason == hal::Reason::disk_full);
  REQUIRE(loaded.ok());
  CHECK(tests::same_map(*old_map, *loaded.value().map));
  CHECK(only_one_file);
}

TEST_CASE("A read-only folder fails clearly and keeps the old map") {
  const TemporaryFolder folder;
  const std::string path = folder / "map.g3d";
  const auto map = tests::random_map(49, 20);
  REQUIRE(save_map(*map, {}, path).ok());
  REQUIRE(chmod(folder.path().c_str(), 0555) == 0);
  // Root may write everywhere: the child gives that up first.
  const pid_t child = in_child([&] {
    if (geteuid() == 0 && (chown(folder.path().c_str(), 65534, 65534) != 0 || setgid(65534) != 0 || setuid(65534) != 0))
      return 0;
    const auto done = save_map(*map, {}, path);
    if (done.ok()) return 1;
    return done.error().reason == hal::Reason::no_permission && done.error().text.find(path) == 0 ? 0 : 2;
  });
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  chmod(folder.path().c_str(), 0755);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
  CHECK(load_map(path).ok());
}
