// SPDX-License-Identifier: Apache-2.0
#include "net/update_manifest.hpp"

#include <catch2/catch.hpp>

#include "tests/support/slot_machine.hpp"

using namespace g3d;
using namespace g3d::net;
using test::system_image;
using test::TempFolder;

TEST_CASE("a manifest says of a file what is in it, and goes through its bytes", "[update]") {
  const TempFolder folder;
  const std::string path = folder / "system.img";
  for (const std::size_t size : {std::size_t{1}, kChunk_bytes - 1, kChunk_bytes, kChunk_bytes + 1, 3 * kChunk_bytes}) {
    const auto bytes = system_image(size, 3);
    test::write_plain(path, bytes);
    const auto manifest = manifest_of(path, 42);
    REQUIRE(manifest.ok());
    const UpdateManifest& made = manifest.value();
    CHECK(made.image == hal::SlotImageId{42, size, digest_of(bytes)});
    REQUIRE(made.chunks.size() == (size + kChunk_bytes - 1) / kChunk_bytes);
    std::size_t sum = 0;
    for (std::uint32_t i = 0; i < made.chunks.size(); ++i) {
      CHECK(made.offset_of(i) == sum);
      CHECK(made.chunks[i] == digest_of(std::span(bytes).subspan(sum, made.size_of(i))));
      sum += made.size_of(i);
    }
    CHECK(sum == size);
    UpdateManifest read;
    REQUIRE(decode_manifest(encode_manifest(made), read) == ManifestFault::none);
    CHECK(read == made);
  }
}

TEST_CASE("a file that is no image says so", "[update]") {
  const TempFolder folder;
  CHECK(manifest_of(folder / "none", 1).error().reason == hal::Reason::not_found);
  CHECK(manifest_of(folder.path(), 1).error().reason == hal::Reason::unsupported);
  const std::string empty = folder / "empty";
  test::write_plain(empty, "");
  CHECK(manifest_of(empty, 1).error().reason == hal::Reason::truncated);
}

TEST_CASE("every cut and every wrong size of a manifest is refused", "[update]") {
  UpdateManifest manifest;
  manifest.image = {7, 2 * kChunk_bytes + 5, {}};
  manifest.chunks.resize(3);
  const auto whole = encode_manifest(manifest);
  UpdateManifest read;
  REQUIRE(decode_manifest(whole, read) == ManifestFault::none);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const ManifestFault fault = decode_manifest(std::span(whole).first(size), read);
    REQUIRE(fault == (size < kManifestHead_bytes ? ManifestFault::too_short : ManifestFault::bad_length));
  }
  auto longer = whole;
  longer.push_back(0);
  CHECK(decode_manifest(longer, read) == ManifestFault::bad_length);
  const auto with_size = [&](std::uint64_t size) {
    auto bytes = whole;
    std::memcpy(&bytes[16], &size, sizeof size);
    return decode_manifest(bytes, read);
  };
  CHECK(with_size(0) == ManifestFault::bad_size);
  CHECK(with_size(kMostImage_bytes + 1) == ManifestFault::bad_size);
  CHECK(with_size(~std::uint64_t{0}) == ManifestFault::bad_size);
  CHECK(with_size(3 * kChunk_bytes + 1) == ManifestFault::bad_length);
  CHECK(with_size(2 * kChunk_bytes) == ManifestFault::bad_length);
  auto other = whole;
  other[3] = 'X';
  CHECK(decode_manifest(other, read) == ManifestFault::no_mark);
  CHECK(read == manifest);
  for (int i = 0; i < 5; ++i) CHECK(std::string(to_string(static_cast<ManifestFault>(i))) != "unknown");
}
