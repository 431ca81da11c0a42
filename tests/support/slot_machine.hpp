// SPDX-License-Identifier: Apache-2.0
// A machine with two slots in a folder, a key that it trusts, and images to send to it.
#pragma once

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "net/update_target.hpp"
#include "tests/support/temp_folder.hpp"

namespace g3d::test {

/// Bytes that no two chunks have in common.
[[nodiscard]] inline std::vector<std::uint8_t> system_image(std::size_t size_bytes, std::uint32_t seed) {
  std::vector<std::uint8_t> bytes(size_bytes);
  std::uint32_t state = seed * 2654435761U + 1;
  for (std::uint8_t& byte : bytes) {
    state = state * 1664525U + 1013904223U;
    byte = static_cast<std::uint8_t>(state >> 24);
  }
  return bytes;
}

class SlotMachine {
 public:
  static constexpr std::uint64_t kRunningRelease = 5;

  SlotMachine() : key(net::SigningKey::random()) {
    write_plain(slot_a(), system_image(1000, 5));
    const auto made = hal::SlotStore(book_path()).change([&](const hal::SlotBook&) -> hal::Result<hal::SlotBook> {
      return hal::first_book({kRunningRelease, 1000, net::digest_of(system_image(1000, 5))});
    });
    REQUIRE(made.ok());
  }

  [[nodiscard]] std::string book_path() const { return folder / "slots"; }
  [[nodiscard]] std::string slot_a() const { return folder / "a.img"; }
  [[nodiscard]] std::string slot_b() const { return folder / "b.img"; }
  [[nodiscard]] net::UpdateTargetPaths paths() const { return {book_path(), {slot_a(), slot_b()}, hal::Slot::a}; }
  [[nodiscard]] hal::SlotBook book() const {
    const auto read = hal::SlotStore(book_path()).read();
    REQUIRE(read.ok());
    return read.value();
  }
  /// A file with that image, and what an update of it says.
  [[nodiscard]] net::UpdateManifest make_image(std::size_t size_bytes, std::uint64_t release) const {
    write_plain(image_path(release), system_image(size_bytes, static_cast<std::uint32_t>(release)));
    const auto manifest = net::manifest_of(image_path(release), release);
    REQUIRE(manifest.ok());
    return manifest.value();
  }
  [[nodiscard]] std::string image_path(std::uint64_t release) const {
    return folder / ("system" + std::to_string(release) + ".img");
  }
  /// Slot A as it was flashed, and a book in which it is good: whatever happens to updates, this holds.
  void check_runs_on() const {
    CHECK(book()[hal::Slot::a].condition == hal::SlotCondition::good);
    CHECK(hal::check_slot_image(slot_a(), book()[hal::Slot::a].image).ok());
  }
  /// B holds that image whole, and starts next.
  void check_installed(const net::UpdateManifest& manifest) const {
    CHECK(book()[hal::Slot::b].condition == hal::SlotCondition::untried);
    CHECK(book()[hal::Slot::b].image == manifest.image);
    CHECK(book().preferred == hal::Slot::b);
    CHECK(hal::check_slot_image(slot_b(), manifest.image).ok());
    check_runs_on();
  }

  TempFolder folder;
  net::SigningKey key;
};

}  // namespace g3d::test
