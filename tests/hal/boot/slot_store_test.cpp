// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/slot_store.hpp"

#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cerrno>
#include <thread>
#include <vector>

#include "hal/disk.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::hal;
using test::TempFolder;

namespace {

/// A disk whose writes are nowhere until they are synced, and whose power goes at one call. What was not synced then is
/// there up to some byte, and after that what was there before, or chance.
class PowerCutDisk final : public Disk {
 public:
  PowerCutDisk(int cut_at_call, std::size_t kept_bytes, bool leaves_chance)
      : cut_at_call_(cut_at_call), kept_bytes_(kept_bytes), leaves_chance_(leaves_chance) {}

  ssize_t pwrite(int fd, const void* data, std::size_t size_bytes, off_t offset) override {
    const auto* const bytes = static_cast<const std::uint8_t*>(data);
    pending_.assign(bytes, bytes + size_bytes);
    offset_ = offset;
    if (is_cut(fd)) return -1;
    return static_cast<ssize_t>(size_bytes);
  }
  int fsync(int fd) override {
    if (is_cut(fd)) return -1;
    keep(fd, pending_.size());
    return 0;
  }
  [[nodiscard]] bool was_cut() const { return was_cut_; }

 private:
  bool is_cut(int fd) {
    if (calls_++ != cut_at_call_ && !was_cut_) return false;
    if (!was_cut_) {
      keep(fd, std::min(kept_bytes_, pending_.size()));
      const std::vector<std::uint8_t> chance(pending_.size() - std::min(kept_bytes_, pending_.size()), 0x5A);
      if (leaves_chance_ && !chance.empty()) {
        REQUIRE(::pwrite(fd, chance.data(), chance.size(), offset_ + static_cast<off_t>(kept_bytes_)) > 0);
      }
    }
    was_cut_ = true;
    errno = EIO;
    return true;
  }
  void keep(int fd, std::size_t size_bytes) {
    if (size_bytes == 0) return;
    REQUIRE(::pwrite(fd, pending_.data(), size_bytes, offset_) == static_cast<ssize_t>(size_bytes));
  }

  const int cut_at_call_;
  const std::size_t kept_bytes_;
  const bool leaves_chance_;
  int calls_ = 0;
  bool was_cut_ = false;
  std::vector<std::uint8_t> pending_;
  off_t offset_ = 0;
};

class RefusingDisk final : public Disk {
 public:
  ssize_t pwrite(int, const void*, std::size_t, off_t) override {
    errno = EROFS;
    return -1;
  }
};

SlotStore::Change to(const SlotBook& book) {
  return [book](SlotBook) -> Result<SlotBook> { return book; };
}

SlotBook book_of(std::uint64_t release) {
  SlotBook book = first_book({release, release, {}});
  book[Slot::b] = {SlotCondition::untried, 0, false, {release + 1, 7, {}}};
  book.preferred = Slot::b;
  return book;
}

}  // namespace

TEST_CASE("the slots' book is kept, and read again", "[slots]") {
  const TempFolder folder;
  SlotStore store(folder / "slots");
  CHECK(store.read().error().reason == Reason::not_found);
  for (std::uint64_t release = 1; release < 6; ++release) {
    REQUIRE(store.change(to(book_of(release))).ok());
    CHECK(SlotStore(store.path()).read().value() == book_of(release));
  }
  CHECK(test::read_plain(store.path()).size() == SlotStore::kRecordDistance_bytes + kSlotRecord_bytes);
  const auto refused = store.change([](SlotBook) -> Result<SlotBook> { return Error{Reason::bad_usage, "no"}; });
  CHECK(refused.error().reason == Reason::bad_usage);
  CHECK(store.read().value() == book_of(5));
}

TEST_CASE("a power cut at any byte of any write leaves the book before or the one after", "[slots]") {
  const TempFolder folder;
  const std::string path = folder / "slots";
  int cuts = 0;
  for (const bool has_two : {false, true}) {
    for (int call = 0; call < 2; ++call) {
      for (std::size_t kept = 0; kept <= kSlotRecord_bytes; ++kept) {
        for (const bool chance : {false, true}) {
          ::unlink(path.c_str());
          SlotStore store(path);
          REQUIRE(store.change(to(book_of(1))).ok());
          if (has_two) REQUIRE(store.change(to(book_of(2))).ok());
          const SlotBook before = store.read().value();
          PowerCutDisk disk(call, kept, chance);
          {
            const DiskInstead instead(disk);
            CHECK_FALSE(store.change(to(book_of(3))).ok());
          }
          cuts += disk.was_cut() ? 1 : 0;
          const auto after = store.read();
          REQUIRE(after.ok());
          REQUIRE((after.value() == before || after.value() == book_of(3)));
          // And it can be written again, over what the cut has left.
          REQUIRE(store.change(to(book_of(4))).ok());
          REQUIRE(store.read().value() == book_of(4));
        }
      }
    }
  }
  CHECK(cuts == 2 * 2 * 513 * 2);
}

TEST_CASE("the first book of all is there or is not", "[slots]") {
  const TempFolder folder;
  const std::string path = folder / "slots";
  for (std::size_t kept = 0; kept <= kSlotRecord_bytes; kept += 16) {
    ::unlink(path.c_str());
    SlotStore store(path);
    PowerCutDisk disk(1, kept, true);
    {
      const DiskInstead instead(disk);
      CHECK_FALSE(store.change(to(book_of(1))).ok());
    }
    const auto after = store.read();
    if (!after) CHECK(after.error().reason == Reason::malformed);
    if (after) CHECK(after.value() == book_of(1));
    REQUIRE(store.change(to(book_of(2))).ok());
    CHECK(store.read().value() == book_of(2));
  }
}

TEST_CASE("any bytes in place of the book are read as one, or as none", "[slots]") {
  const TempFolder folder;
  const std::string path = folder / "slots";
  SlotStore store(path);
  for (const std::string& text : {std::string(), std::string("x"), std::string(9000, '\0'), std::string(9000, 'G')}) {
    test::write_plain(path, text);
    const auto read = store.read();
    REQUIRE_FALSE(read.ok());
    CHECK(read.error().reason == Reason::malformed);
    CHECK_THAT(read.error().text, Catch::Contains(path));
  }
  // One record is enough.
  REQUIRE(store.change(to(book_of(1))).ok());
  REQUIRE(store.change(to(book_of(2))).ok());
  std::string text = test::read_plain(path);
  for (const std::size_t spoilt : {std::size_t{0}, SlotStore::kRecordDistance_bytes}) {
    std::string one = text;
    one[spoilt + 20] = 'x';
    test::write_plain(path, one);
    CHECK(store.read().value() == book_of(spoilt == 0 ? 2 : 1));
  }
}

TEST_CASE("an unchanged book is not written", "[slots]") {
  const TempFolder folder;
  SlotStore store(folder / "slots");
  REQUIRE(store.change(to(book_of(1))).ok());
  RefusingDisk refusing;
  const DiskInstead instead(refusing);
  CHECK(store.change(to(book_of(1))).ok());
  CHECK(store.change(to(book_of(2))).error().reason == Reason::no_permission);
}

TEST_CASE("a start is on the disk before it is answered", "[slots]") {
  const TempFolder folder;
  SlotStore store(folder / "slots");
  REQUIRE(store.change(to(book_of(1))).ok());
  for (int i = 1; i <= kMostFailedStarts; ++i) {
    const SlotChoice choice = choose_slot(store);
    CHECK(choice.slot == Slot::b);
    CHECK(choice.is_counted);
    CHECK(choice.trouble.empty());
    CHECK(SlotStore(store.path()).read().value()[Slot::b].starts == i);
  }
  const SlotChoice choice = choose_slot(store);
  CHECK(choice.slot == Slot::a);
  CHECK(choice.given_up == Slot::b);
  CHECK_FALSE(choose_slot(store).given_up);
}

TEST_CASE("a start that cannot be counted is one of a system that is good", "[slots]") {
  const TempFolder folder;
  SlotStore store(folder / "slots");
  REQUIRE(store.change(to(book_of(1))).ok());
  RefusingDisk refusing;
  {
    const DiskInstead instead(refusing);
    for (int i = 0; i < 5; ++i) {
      const SlotChoice choice = choose_slot(store);
      CHECK(choice.slot == Slot::a);
      CHECK_FALSE(choice.is_counted);
      CHECK_THAT(choice.trouble, Catch::Contains("cannot write"));
    }
    UnusableSlots unusable;
    unusable.add(Slot::a);
    CHECK(choose_slot(store, unusable).slot == Slot::b);  // nothing else is there
  }
  CHECK(choose_slot(store).slot == Slot::b);
}

TEST_CASE("without a book, or a disk for it, something is started", "[slots]") {
  const TempFolder folder;
  SlotStore none(folder.path() + "/no/such/folder/slots");
  const SlotChoice blind = choose_slot(none);
  CHECK(blind.slot == Slot::a);
  CHECK_FALSE(blind.is_counted);
  CHECK_FALSE(blind.trouble.empty());
  SlotStore lost(folder / "slots");
  const SlotChoice first = choose_slot(lost);
  CHECK(first.slot == Slot::a);
  CHECK(first.is_counted);
  CHECK_FALSE(first.trouble.empty());
  UnusableSlots both;
  both.add(Slot::a);
  both.add(Slot::b);
  CHECK_FALSE(choose_slot(lost, both).slot);
}

TEST_CASE("two who change the book at once lose no change", "[slots][threads]") {
  const TempFolder folder;
  const std::string path = folder / "slots";
  REQUIRE(SlotStore(path).change(to(book_of(0))).ok());
  constexpr int kChanges = 40;
  const auto count_up = [&path] {
    SlotStore store(path);
    for (int i = 0; i < kChanges; ++i) {
      (void)store.change([](SlotBook book) -> Result<SlotBook> {
        ++book.newest_good_release;
        return book;
      });
    }
  };
  std::thread one(count_up), two(count_up);
  one.join();
  two.join();
  CHECK(SlotStore(path).read().value().newest_good_release == 2 * kChanges);
}
