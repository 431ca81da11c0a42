// SPDX-License-Identifier: Apache-2.0
#include "net/fleet_key_file.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "hal/disk.hpp"
#include "tests/support/temp_folder.hpp"

namespace {

using namespace g3d;
using namespace g3d::net;
using hal::Reason;
using test::TempFolder;

const std::string kKey(64, 'a'), kOther(64, 'b');
const std::string kHead = "g3dmap fleet key 1\n";

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

FleetKey full_key() {
  FleetKey keys = generate_fleet_key();
  rotate_fleet_key(keys, OldKey::kept_until_finished);
  REQUIRE(revoke_robot(keys, 0xDEADBEEF).ok());
  REQUIRE(revoke_robot(keys, 3).ok());
  return keys;
}

bool same(const FleetKey& a, const FleetKey& b) {
  if (a.epoch != b.epoch || !a.key.equals(b.key) || a.revoked != b.revoked || a.dropped != b.dropped) return false;
  if (a.previous.has_value() != b.previous.has_value()) return false;
  return !a.previous || a.previous->equals(*b.previous);
}

mode_t mode_of(const std::string& path) {
  struct stat status {};
  REQUIRE(::stat(path.c_str(), &status) == 0);
  return status.st_mode & 07777;
}

TEST_CASE("a fleet key goes through its file") {
  const TempFolder folder;
  const std::string path = folder / "fleet.key";
  for (const bool plain : {true, false}) {
    const FleetKey keys = plain ? generate_fleet_key() : full_key();
    REQUIRE(write_fleet_key(path, keys).ok());
    const auto read = read_fleet_key(path);
    REQUIRE(read.ok());
    CHECK(same(read.value(), keys));
  }
  CHECK(folder.listing() == "fleet.key\n");
}

TEST_CASE("only its owner can read it, whatever the umask and whatever was there") {
  const TempFolder folder;
  const std::string path = folder / "fleet.key";
  const mode_t before = ::umask(0);
  test::write_plain(path, "old");
  const bool written = write_fleet_key(path, generate_fleet_key()).ok();
  ::umask(before);
  REQUIRE(written);
  CHECK(mode_of(path) == 0600);
}

TEST_CASE("a key that others can get at is refused, with the remedy") {
  const TempFolder folder;
  const std::string path = folder / "fleet.key";
  REQUIRE(write_fleet_key(path, generate_fleet_key()).ok());
  for (const mode_t mode : {0640U, 0604U, 0620U, 0602U, 0610U, 0666U}) {
    REQUIRE(::chmod(path.c_str(), mode) == 0);
    const auto read = read_fleet_key(path);
    REQUIRE_FALSE(read.ok());
    CHECK(read.error().reason == Reason::no_permission);
    CHECK(has(read.error().text, "chmod 600 " + path));
  }
  REQUIRE(::chmod(path.c_str(), 0400) == 0);
  CHECK(read_fleet_key(path).ok());
}

TEST_CASE("what is no file of a key is refused, and does not stop the reader") {
  const TempFolder folder;
  CHECK(read_fleet_key(folder / "none").error().reason == Reason::not_found);
  REQUIRE(::chmod(folder.path().c_str(), 0700) == 0);
  CHECK(read_fleet_key(folder.path()).error().reason == Reason::unsupported);
  const std::string pipe = folder / "pipe", large = folder / "large";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  CHECK(read_fleet_key(pipe).error().reason == Reason::unsupported);
  test::write_plain(large, kHead + std::string(kMostKeyFile_bytes, '\n'));
  REQUIRE(::chmod(large.c_str(), 0600) == 0);
  CHECK(read_fleet_key(large).error().reason == Reason::too_large);
}

TEST_CASE("comments and blank lines say nothing, and the order of lines is free") {
  const auto read = parse_fleet_key("# a\n\n" + kHead + "revoked ff\nkey " + kKey + "\n\n# b\nepoch 65535\n", "f");
  REQUIRE(read.ok());
  CHECK(read.value().epoch == 65535);
  CHECK(read.value().revoked == std::vector<std::uint64_t>{255});
}

TEST_CASE("every line that is wrong is named, and the key is not") {
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"", "f: has no first line"},
      {"epoch 1\n", "f:1: is not the first line"},
      {"g3dmap fleet key 2\n", "f:1: is a fleet key of another version"},
      {kHead, "f: has no epoch"},
      {kHead + "epoch 1\n", "f: has no key"},
      {kHead + "key " + kKey + "\n", "f: has no epoch"},
      {kHead + "epoch 1\nkey " + kKey, "f: its last line has no end"},
      {kHead + "epoch 65536\n", "f:2: epoch is not"},
      {kHead + "epoch -1\n", "f:2: epoch is not"},
      {kHead + "epoch \n", "f:2: epoch is not"},
      {kHead + "epoch 1 \n", "f:2: epoch is not"},
      {kHead + "epoch 1\nepoch 1\n", "f:3: epoch stands here a second time"},
      {kHead + "key " + kKey + "\nkey " + kKey + "\n", "f:3: key stands here a second time"},
      {kHead + "previous " + kKey + "\nprevious " + kKey + "\n", "f:3: previous stands here a second time"},
      {kHead + "key " + kKey + "\r\n", "f:2: key is not 64"},
      {kHead + "key " + kKey.substr(1) + "\n", "f:2: key is not 64"},
      {kHead + "key " + std::string(64, '0') + "\n", "f:2: key is all zeros"},
      {kHead + "previous x\n", "f:2: previous is not 64"},
      {kHead + "revoked\n", "f:2: is not WORD VALUE"},
      {kHead + "revoked xyz\n", "f:2: revoked is not"},
      {kHead + "dropped xyz\n", "f:2: dropped is not"},
      {kHead + "dropped 1\ndropped 01\n", "f:3: this robot is dropped a second time"},
      {kHead + "revoked 1\nrevoked 01\n", "f:3: this robot is revoked a second time"},
      {kHead + "kex " + kKey + "\n", "f:2: begins with none of"},
  };
  for (const auto& [text, says] : wrong) {
    const auto read = parse_fleet_key(text, "f");
    INFO(text);
    REQUIRE_FALSE(read.ok());
    INFO(read.error().text);
    CHECK(has(read.error().text, says));
    CHECK(has(read.error().text, ";"));
    CHECK_FALSE(has(read.error().text, "aaaa"));
  }
}

TEST_CASE("more robots than can be revoked are refused by line") {
  std::string text = kHead;
  for (std::size_t i = 0; i <= FleetKey::kMostRevoked; ++i) text += "revoked " + std::to_string(i) + "\n";
  const auto read = parse_fleet_key(text, "f");
  REQUIRE_FALSE(read.ok());
  CHECK(has(read.error().text, "f:258: 256 robots are revoked already"));
  FleetKey most = full_key();
  for (std::uint64_t i = 0; most.revoked.size() < FleetKey::kMostRevoked; ++i) (void)drop_robot(most, ~i);
  const std::string largest = format_fleet_key(most);
  CHECK(largest.size() < kMostKeyFile_bytes);
  CHECK(parse_fleet_key(largest, "f").ok());
}

TEST_CASE("every cut of a file is refused or no shorter key") {
  const std::string whole = format_fleet_key(full_key());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const auto read = parse_fleet_key(whole.substr(0, size), "f");
    if (read.ok())
      CHECK((size == whole.find("previous") || size == whole.find("revoked") || size == whole.rfind("revoked")));
  }
}

TEST_CASE("a disk that fails leaves the old key and no part of the new one") {
  class FullDisk final : public hal::Disk {
   public:
    ssize_t write(int, const void*, std::size_t) override {
      errno = ENOSPC;
      return -1;
    }
  } full;
  const TempFolder folder;
  const std::string path = folder / "fleet.key";
  const FleetKey keys = full_key();
  REQUIRE(write_fleet_key(path, keys).ok());
  {
    const hal::DiskInstead instead(full);
    CHECK(write_fleet_key(path, generate_fleet_key()).error().reason == Reason::disk_full);
  }
  CHECK(same(read_fleet_key(path).value(), keys));
  CHECK(folder.listing() == "fleet.key\n");
}

}  // namespace
