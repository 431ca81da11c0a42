// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/line_recorder.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <cerrno>
#include <string>
#include <thread>
#include <vector>

#include "hal/disk.hpp"
#include "hal/replay/kobuki_log.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using hal::Reason;
using hal::TimeNs;
using hal::kobuki::LineRecorder;

namespace {

struct Record {
  TimeNs t_ns = 0;
  std::vector<std::uint8_t> bytes;
};

// As the reader of such files sees it.
std::vector<Record> records_of(const std::string& path) {
  const auto log = hal::KobukiLog::open(path);
  REQUIRE(log.ok());
  CHECK(log.value().torn_bytes() == 0);
  std::vector<Record> records;
  for (auto cursor = log.value().records(); cursor.peek(); cursor.advance()) {
    const auto record = *cursor.peek();
    records.push_back({record.t_ns, {record.bytes.begin(), record.bytes.end()}});
  }
  return records;
}

}  // namespace

TEST_CASE("Records are in the file as they were put", "[threads]") {
  const test::TempFolder folder;
  auto recorder = LineRecorder::create(folder / "kobuki.bin");
  REQUIRE(recorder.ok());
  for (int i = 0; i < 500; ++i) {
    const std::vector<std::uint8_t> bytes(static_cast<std::size_t>(1 + i % 90), static_cast<std::uint8_t>(i));
    recorder.value()->put(bytes, 0x0002030405060708 + i);
  }
  recorder.value()->put({}, 1);
  REQUIRE(recorder.value()->finish().ok());
  CHECK(recorder.value()->lost_bytes() == 0);
  const auto records = records_of(folder / "kobuki.bin");
  REQUIRE(records.size() == 500);
  for (int i = 0; i < 500; ++i) {
    const Record& record = records[static_cast<std::size_t>(i)];
    REQUIRE(record.t_ns == 0x0002030405060708 + i);
    REQUIRE(record.bytes ==
            std::vector<std::uint8_t>(static_cast<std::size_t>(1 + i % 90), static_cast<std::uint8_t>(i)));
  }
}

TEST_CASE("What is longer than a record is split, nothing lost", "[threads]") {
  const test::TempFolder folder;
  std::vector<std::uint8_t> bytes(1000);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * 7);
  {
    auto recorder = LineRecorder::create(folder / "kobuki.bin");
    REQUIRE(recorder.ok());
    recorder.value()->put(bytes, 5);
  }  // the destructor finishes too
  std::vector<std::uint8_t> joined;
  for (const Record& record : records_of(folder / "kobuki.bin")) {
    CHECK(record.t_ns == 5);
    joined.insert(joined.end(), record.bytes.begin(), record.bytes.end());
  }
  CHECK(joined == bytes);
}

TEST_CASE("A full disk is said, and what was lost is counted", "[threads]") {
  auto recorder = LineRecorder::create("/dev/full");
  REQUIRE(recorder.ok());
  recorder.value()->put(std::vector<std::uint8_t>(100), 1);
  recorder.value()->put(std::vector<std::uint8_t>(50), 2);
  const auto result = recorder.value()->finish();
  REQUIRE_FALSE(result.ok());
  CHECK(result.error().reason == Reason::disk_full);
  CHECK(recorder.value()->lost_bytes() == 150);
}

TEST_CASE("A disk that hangs costs records, not time", "[threads]") {
  const test::TempFolder folder;
  // A pipe that nobody reads: the writer hangs in the middle of a write.
  REQUIRE(::mkfifo((folder / "pipe").c_str(), 0600) == 0);
  const int reader = ::open((folder / "pipe").c_str(), O_RDONLY | O_NONBLOCK);
  auto recorder = LineRecorder::create(folder / "pipe");
  REQUIRE(recorder.ok());
  const std::vector<std::uint8_t> bytes(240, 1);
  for (int i = 0; i < 3'000; ++i) recorder.value()->put(bytes, i);
  CHECK(recorder.value()->lost_bytes() > 0);
  std::vector<char> sink(65'536);  // now the disk goes on
  std::atomic<bool> over{false};
  std::thread drain([&] {
    while (!over.load()) (void)!::read(reader, sink.data(), sink.size());
  });
  CHECK(recorder.value()->finish().ok());
  over.store(true);
  drain.join();
  ::close(reader);
}

TEST_CASE("A recording that is under way is not begun again by another", "[threads]") {
  const test::TempFolder folder;
  auto first = LineRecorder::create(folder / "kobuki.bin");
  REQUIRE(first.ok());
  first.value()->put(std::vector<std::uint8_t>(40, 1), 7);
  CHECK(LineRecorder::create(folder / "kobuki.bin").error().reason == Reason::no_permission);
  REQUIRE(first.value()->finish().ok());
  CHECK(records_of(folder / "kobuki.bin").size() == 1);
  CHECK(LineRecorder::create(folder / "kobuki.bin").ok());
}

TEST_CASE("A file that cannot be made says why") {
  const test::TempFolder folder;
  const auto recorder = LineRecorder::create(folder.path() + "/no/such/kobuki.bin");
  REQUIRE_FALSE(recorder.ok());
  CHECK(recorder.error().reason == Reason::not_found);
  CHECK(recorder.error().text.find("kobuki.bin") != std::string::npos);
}

TEST_CASE("After a disk that refused, or took half a record, whole ones follow", "[threads]") {
  class Moody final : public hal::Disk {
   public:
    ssize_t write(int fd, const void* data, std::size_t size_bytes) override {
      const int call = calls.fetch_add(1);
      if (call == 1) return Disk::write(fd, data, size_bytes / 2);
      if (call == 2 || call == 5) {
        errno = ENOSPC;
        return -1;
      }
      return Disk::write(fd, data, size_bytes);
    }
    std::atomic<int> calls{0};
  } disk;
  const hal::DiskInstead instead(disk);
  const test::TempFolder folder;
  auto recorder = LineRecorder::create(folder / "kobuki.bin");
  REQUIRE(recorder.ok());
  for (int i = 0; i < 6; ++i) {
    recorder.value()->put(std::vector<std::uint8_t>(40, static_cast<std::uint8_t>(i)), i);
  }
  CHECK(recorder.value()->finish().error().reason == Reason::disk_full);
  CHECK(recorder.value()->lost_bytes() == 80);
  const std::vector<Record> records = records_of(folder / "kobuki.bin");
  std::vector<TimeNs> stamps;
  for (const Record& record : records) stamps.push_back(record.t_ns);
  CHECK(stamps == std::vector<TimeNs>{0, 2, 3, 5});
}
