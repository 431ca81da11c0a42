// SPDX-License-Identifier: Apache-2.0
#include "net/journal_writer.hpp"

#include <fcntl.h>
#include <catch2/catch.hpp>

#include <cerrno>
#include <string_view>

#include "hal/disk.hpp"
#include "net/journal_restore.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using mapper::Bytes;
using net::JournalCommand;
using net::JournalWriter;

namespace {

struct FailingDisk final : hal::Disk {
  [[nodiscard]] ssize_t write(int fd, const void* data, std::size_t size_bytes) override {
    errno = EIO;
    return fails ? -1 : Disk::write(fd, data, size_bytes);
  }
  [[nodiscard]] int open(const char* path, int flags, mode_t mode) override {
    errno = EROFS;
    return fails && (flags & O_ACCMODE) != O_RDONLY ? -1 : Disk::open(path, flags, mode);
  }
  bool fails = false;
};

Bytes writer_entry(net::Version version) {
  Bytes entry;
  net::StoredRecord record;
  record.key = net::block_record(0, version, net::Part::whole);
  record.version = version;
  net::add_layer_entry(entry, {1, 1});
  net::add_record_entry(entry, record, Bytes(20, 7));
  return entry;
}

std::uint32_t records_in(const std::string& path) {
  net::LayerStore store({2, 1000, 100000});
  const auto restored = net::restore_layers(path, store);
  REQUIRE(restored.ok());
  CHECK_FALSE(restored.value().is_damaged());
  return store.record_count();
}

Bytes number_of(std::uint64_t number) {
  Bytes bytes;
  mapper::put(bytes, number);
  return bytes;
}

}  // namespace

TEST_CASE("what is pushed is in the journal, and in the new one while that is made", "[net]") {
  const test::TempFolder folder;
  JournalWriter writer(folder / "j", folder / "id", 1 << 16);
  CHECK(writer.needs_new());
  writer.open(std::nullopt);
  CHECK_FALSE(writer.needs_new());
  for (net::Version v = 1; v <= 10; ++v) REQUIRE(writer.push(JournalCommand::change, writer_entry(v)));
  CHECK(records_in(folder / "j") == 0);
  writer.work();
  CHECK(records_in(folder / "j") == 10);
  CHECK(writer.counts().frames == 1);
  // The layer is named once in a frame.
  CHECK(writer.journal_bytes() < 10 * writer_entry(1).size());

  REQUIRE(writer.push(JournalCommand::new_begin, number_of(1)));
  REQUIRE(writer.push(JournalCommand::new_entry, writer_entry(3)));
  REQUIRE(writer.push(JournalCommand::change, writer_entry(11)));
  writer.work();
  CHECK(records_in(folder / "j") == 11);
  CHECK(writer.placed_new() == 0);
  REQUIRE(writer.push(JournalCommand::new_end, {}));
  REQUIRE(writer.push(JournalCommand::change, writer_entry(12)));
  REQUIRE(writer.push(JournalCommand::sync, {}));
  writer.work();
  CHECK(writer.placed_new() == 1);
  CHECK(records_in(folder / "j") == 3);
  CHECK(writer.synced_bytes() == writer.journal_bytes());
  CHECK(folder.listing() == "j\n");
}

TEST_CASE("a journal that the disk refuses stays as it is until a new one takes its place", "[net]") {
  const test::TempFolder folder;
  FailingDisk disk;
  const hal::DiskInstead instead(disk);
  JournalWriter writer(folder / "j", folder / "id", 1 << 16);
  writer.open(std::nullopt);
  REQUIRE(writer.push(JournalCommand::change, writer_entry(1)));
  writer.work();
  disk.fails = true;
  REQUIRE(writer.push(JournalCommand::change, writer_entry(2)));
  writer.work();
  CHECK(writer.needs_new());
  disk.fails = false;
  // What comes later may stand on what is missing.
  REQUIRE(writer.push(JournalCommand::change, writer_entry(3)));
  writer.work();
  CHECK(records_in(folder / "j") == 1);
  CHECK(writer.counts().failures == 1);
  CHECK(writer.counts().discarded_entries == 1);
  net::JournalTrouble trouble;
  REQUIRE(writer.trouble().read(trouble) == 1);
  CHECK(std::string_view(trouble.text.data()).find(folder / "j") != std::string_view::npos);

  disk.fails = true;
  REQUIRE(writer.push(JournalCommand::new_begin, number_of(1)));
  writer.work();
  CHECK(writer.ended_new() == 1);
  CHECK(writer.placed_new() == 0);
  disk.fails = false;
  REQUIRE(writer.push(JournalCommand::new_begin, number_of(2)));
  for (const net::Version v : {1U, 2U, 3U}) REQUIRE(writer.push(JournalCommand::new_entry, writer_entry(v)));
  REQUIRE(writer.push(JournalCommand::new_end, {}));
  REQUIRE(writer.push(JournalCommand::change, writer_entry(4)));
  writer.work();
  CHECK(writer.placed_new() == 2);
  CHECK_FALSE(writer.needs_new());
  CHECK(records_in(folder / "j") == 4);
}

TEST_CASE("a reservation counts once the disk has it", "[net]") {
  const test::TempFolder folder;
  FailingDisk disk;
  const hal::DiskInstead instead(disk);
  JournalWriter writer(folder / "j", folder / "id", 1 << 16);
  const net::LayerIdentity identity{{1, 2}, 500};
  const Bytes bytes(reinterpret_cast<const std::uint8_t*>(&identity),
                    reinterpret_cast<const std::uint8_t*>(&identity) + sizeof identity);
  disk.fails = true;
  REQUIRE(writer.push(JournalCommand::reserve, bytes));
  writer.work();
  CHECK(writer.reserved() == 0);
  disk.fails = false;
  REQUIRE(writer.push(JournalCommand::reserve, bytes));
  writer.work();
  CHECK(writer.reserved() == 500);
  CHECK(net::read_layer_identity(folder / "id").value() == identity);
}
