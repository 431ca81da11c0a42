// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/slot_store.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <utility>

#include "hal/disk.hpp"
#include "hal/image/atomic_file.hpp"

namespace g3d::hal {
namespace {

constexpr std::size_t kRecords = 2;

class SlotFile {
 public:
  explicit SlotFile(int fd) : fd_(fd) {}
  ~SlotFile() {
    if (fd_ >= 0) ::close(fd_);  // and the lock goes
  }
  SlotFile(const SlotFile&) = delete;
  SlotFile& operator=(const SlotFile&) = delete;
  [[nodiscard]] int fd() const { return fd_; }

 private:
  int fd_;
};

off_t record_offset(std::size_t index) { return static_cast<off_t>(index * SlotStore::kRecordDistance_bytes); }

struct FoundRecord {
  bool is_there = false;
  std::size_t index = 0;
  SlotRecord record;
  SlotRecordFault fault = SlotRecordFault::no_mark;  ///< of the last one that could not be used
};

/// Returns 0 or errno. A short file has no record there.
int read_records(int fd, FoundRecord& found) {
  for (std::size_t i = 0; i < kRecords; ++i) {
    SlotRecordBytes bytes{};
    std::size_t had = 0;
    while (had < bytes.size()) {
      const ssize_t n =
          disk().pread(fd, bytes.data() + had, bytes.size() - had, record_offset(i) + static_cast<off_t>(had));
      if (n < 0 && errno == EINTR) continue;
      // A sector that cannot be read is a record that cannot be used; the other one may be well.
      if (n < 0 && errno != EIO) return errno;
      if (n <= 0) break;
      had += static_cast<std::size_t>(n);
    }
    SlotRecord record;
    const SlotRecordFault fault = decode_slot_record(std::span(bytes).first(had), record);
    if (fault != SlotRecordFault::none) {
      found.fault = fault;
      continue;
    }
    if (found.is_there && record.sequence <= found.record.sequence) continue;
    found.is_there = true;
    found.index = i;
    found.record = record;
  }
  return 0;
}

/// Returns 0 or errno.
int write_record(int fd, std::size_t index, const SlotRecord& record) {
  const SlotRecordBytes bytes = encode_slot_record(record);
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n =
        disk().pwrite(fd, bytes.data() + done, bytes.size() - done, record_offset(index) + static_cast<off_t>(done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return n < 0 ? errno : EIO;
    done += static_cast<std::size_t>(n);
  }
  return disk().fsync(fd) == 0 ? 0 : errno;
}

int sync_folder_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : slash == 0 ? "/" : path.substr(0, slash);
  const SlotFile opened(disk().open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC, 0));
  if (opened.fd() < 0 || disk().fsync(opened.fd()) == 0) return opened.fd() < 0 ? errno : 0;
  return errno == EINVAL || errno == ENOTSUP ? 0 : errno;
}

Error unreadable_book(const std::string& path, SlotRecordFault fault) {
  return {Reason::malformed,
          fmt::format("{}: neither of its two records can be used ({}); both slots are tried in turn, "
                      "and the next start that goes well writes it anew",
                      path, to_string(fault))};
}

}  // namespace

Result<SlotBook> SlotStore::read() const {
  const SlotFile file(disk().open(path_.c_str(), O_RDONLY | O_CLOEXEC, 0));
  if (file.fd() < 0) return system_error(path_, "cannot open", errno);
  if (::flock(file.fd(), LOCK_SH) != 0) return system_error(path_, "cannot lock", errno);
  FoundRecord found;
  if (const int failed = read_records(file.fd(), found); failed != 0) return system_error(path_, "cannot read", failed);
  if (!found.is_there) return unreadable_book(path_, found.fault);
  return found.record.book;
}

Result<SlotBook> SlotStore::change(const Change& how, const SlotBook& if_lost) {
  bool is_new = false;
  int fd = disk().open(path_.c_str(), O_RDWR | O_CLOEXEC, 0);
  if (fd < 0 && errno == ENOENT) {
    fd = disk().open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    is_new = true;
  }
  const SlotFile file(fd);
  if (fd < 0) return system_error(path_, "cannot open", errno);
  if (::flock(fd, LOCK_EX) != 0) return system_error(path_, "cannot lock", errno);
  FoundRecord found;
  if (const int failed = read_records(fd, found); failed != 0) return system_error(path_, "cannot read", failed);
  Result<SlotBook> changed = how(found.is_there ? found.record.book : if_lost);
  if (!changed) return changed;
  if (found.is_there && changed.value() == found.record.book) return changed;
  const SlotRecord next{found.is_there ? found.record.sequence + 1 : 1, changed.value()};
  const std::size_t index = found.is_there ? (found.index + 1) % kRecords : 0;
  if (const int failed = write_record(fd, index, next); failed != 0) return system_error(path_, "cannot write", failed);
  if (is_new) {
    if (const int failed = sync_folder_of(path_); failed != 0)
      return system_error(path_, "cannot sync its folder", failed);
  }
  return changed;
}

SlotChoice choose_slot(SlotStore& store, const UnusableSlots& unusable) {
  SlotChoice choice;
  if (const auto before = store.read(); !before) choice.trouble = before.error().text;
  std::optional<StartPlan> plan;
  SlotBook seen = lost_book();
  const auto kept = store.change([&](SlotBook book) -> Result<SlotBook> {
    seen = book;
    plan = plan_start(book, unusable);
    return plan ? plan->book : book;
  });
  if (kept) {
    if (!plan) return choice;
    choice.slot = plan->slot;
    choice.given_up = plan->given_up;
    choice.is_counted = true;
    return choice;
  }
  choice.trouble = kept.error().text;
  if (!plan) plan = plan_start(seen, unusable);
  if (!plan) return choice;
  const Slot second = other_slot(plan->slot);
  const bool prefers_good = seen[plan->slot].condition != SlotCondition::good && !unusable.has(second) &&
                            seen[second].condition == SlotCondition::good;
  choice.slot = prefers_good ? second : plan->slot;
  return choice;
}

}  // namespace g3d::hal
