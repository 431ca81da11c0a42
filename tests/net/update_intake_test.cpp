// SPDX-License-Identifier: Apache-2.0
#include "net/update_intake.hpp"

#include <sys/types.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <random>

#include "hal/disk.hpp"
#include "tests/support/update_talk.hpp"

using namespace g3d;
using namespace g3d::net;
using hal::Slot;
using hal::SlotCondition;
using test::SlotMachine;
using test::system_image;
using test::talk;
using test::TalkOptions;
using test::TalkResult;

namespace {

constexpr std::size_t kImage_bytes = 5 * kChunk_bytes + 1234;

struct Bench {
  SlotMachine machine;
  std::uint64_t release = 6;
  std::vector<std::uint8_t> image = system_image(kImage_bytes, 6);
  UpdateManifest manifest = machine.make_image(kImage_bytes, 6);

  TalkResult send(const TalkOptions& options = {}) {
    UpdateTarget target(machine.paths());
    return talk(target, machine.key.update_key(), machine.key, manifest, image, options);
  }
};

}  // namespace

TEST_CASE("an update is taken whole, and sent once more it is there", "[update]") {
  Bench bench;
  const TalkResult first = bench.send();
  CHECK(first.end == UpdateEnd::installed);
  CHECK(first.chunks == 6);
  CHECK(first.makes_sense);
  CHECK(first.most_held_bytes <= kChunkHead_bytes + kChunk_bytes);
  bench.machine.check_installed(bench.manifest);
  const TalkResult second = bench.send();
  CHECK(second.end == UpdateEnd::already_there);
  CHECK(second.chunks == 0);
}

TEST_CASE("an update that is cut anywhere goes on where it was", "[update]") {
  std::mt19937 chance(7);
  for (int round = 0; round < 12; ++round) {
    Bench bench;
    std::uint32_t chunks = 0;
    std::uint64_t sent_bytes = 0;
    int cuts = 0;
    for (;; ++cuts) {
      TalkOptions options;
      // At a byte of the proof, of the manifest, of any chunk.
      options.cut_after_bytes = cuts < 8 ? 1 + chance() % (kImage_bytes / 2) : ~std::uint64_t{0};
      const TalkResult result = bench.send(options);
      sent_bytes += result.sent_bytes;
      chunks += result.chunks;
      if (result.end) {
        CHECK(result.end == UpdateEnd::installed);
        break;
      }
      bench.machine.check_runs_on();
      CHECK(hal::plan_start(bench.machine.book())->slot == Slot::a);
    }
    bench.machine.check_installed(bench.manifest);
    // What was asked for ahead when the line was cut is asked for again.
    CHECK(chunks <= 6 + static_cast<std::uint32_t>(cuts) * kMostWanted);
    // Of the image nothing is sent twice but the chunk that was on its way.
    CHECK(sent_bytes <=
          kImage_bytes + static_cast<std::uint64_t>(cuts + 1) * (kProof_bytes + 56 + 6 * 32 + kChunk_bytes + 100));
  }
}

TEST_CASE("only what differs from what the slot holds is sent", "[update]") {
  Bench bench;
  auto old = bench.image;
  old[2 * kChunk_bytes + 17] ^= 1U;
  old[kImage_bytes - 1] ^= 1U;
  test::write_plain(bench.machine.slot_b(), old);
  const TalkResult result = bench.send();
  CHECK(result.end == UpdateEnd::installed);
  CHECK(result.chunks == 2);
  bench.machine.check_installed(bench.manifest);
}

TEST_CASE("who does not hold the key has nothing parsed and nothing written", "[update]") {
  Bench bench;
  const auto before = bench.machine.book();
  UpdateTarget target(bench.machine.paths());
  const SigningKey stranger = SigningKey::random();
  const TalkResult result = talk(target, bench.machine.key.update_key(), stranger, bench.manifest, bench.image, {});
  CHECK(result.end == UpdateEnd::wrong_key);
  CHECK(result.sent_bytes == kProof_bytes);
  CHECK(bench.machine.book() == before);
  CHECK(bench.machine.folder.listing().find("b.img") == std::string::npos);
}

TEST_CASE("an update that was recorded is worth nothing", "[update]") {
  Bench bench;
  UpdateTarget target(bench.machine.paths());
  UpdateIntake first(bench.machine.key.update_key(), target, {1}, 1e9);
  UpdateOffer offer(bench.manifest, bench.machine.key, true);
  GreetingBytes greeting;
  std::copy_n(first.says().begin(), greeting.size(), greeting.begin());
  REQUIRE(offer.take_greeting(greeting));
  const auto recorded = offer.opening();
  const auto feed = [&](UpdateIntake& intake) {
    const auto wants = intake.wants();
    std::copy_n(recorded.begin(), wants.size(), wants.begin());
    intake.took(wants.size());
  };
  UpdateIntake second(bench.machine.key.update_key(), target, {2}, 1e9);
  feed(second);
  CHECK(second.end() == UpdateEnd::wrong_key);
  feed(first);
  CHECK_FALSE(first.end());
  CHECK(first.is_proved());
}

TEST_CASE("a byte that is changed on the way changes nothing on the machine", "[update]") {
  Bench bench;
  std::mt19937 chance(3);
  const std::size_t opening_bytes = kProof_bytes + encode_manifest(bench.manifest).size();
  for (int round = 0; round < 60; ++round) {
    const std::uint64_t spoilt = round < 30 ? chance() % opening_bytes : chance() % kImage_bytes;
    TalkOptions options;
    options.spoil = [&](std::uint64_t offset, std::vector<std::uint8_t>& bytes) {
      if (spoilt >= offset && spoilt < offset + bytes.size()) bytes[spoilt - offset] ^= 0x10U;
    };
    const TalkResult result = bench.send(options);
    INFO("byte " << spoilt);
    REQUIRE(result.end);
    if (result.end == UpdateEnd::installed) {
      // The chunk that would have been hit was there already.
      bench.machine.check_installed(bench.manifest);
      break;
    }
    const bool is_proof = spoilt < kProof_bytes;
    CHECK((result.end == (is_proof ? UpdateEnd::wrong_key : UpdateEnd::wrong_chunk) ||
           (!is_proof && result.end == UpdateEnd::malformed)));
    bench.machine.check_runs_on();
    REQUIRE(hal::plan_start(bench.machine.book())->slot == Slot::a);
  }
  CHECK(bench.send().end != UpdateEnd::wrong_chunk);
  bench.machine.check_installed(bench.manifest);
}

TEST_CASE("an older release is refused, unless the key's holder means it", "[update]") {
  Bench bench;
  bench.manifest = bench.machine.make_image(kImage_bytes, 4);
  bench.image = system_image(kImage_bytes, 4);
  CHECK(bench.send().end == UpdateEnd::not_newer);
  CHECK(bench.machine.book()[Slot::b].condition == SlotCondition::empty);
  TalkOptions options;
  options.force = true;
  CHECK(bench.send(options).end == UpdateEnd::installed);
  CHECK(bench.machine.book()[Slot::b].may_go_back);
  CHECK(hal::started_well(bench.machine.book(), Slot::b).newest_good_release == 4);
}

TEST_CASE("a manifest that contradicts itself is not installed", "[update]") {
  Bench bench;
  bench.manifest.image.digest[0] ^= 1U;
  CHECK(bench.send().end == UpdateEnd::malformed);
  CHECK(bench.machine.book()[Slot::b].condition == SlotCondition::empty);
}

TEST_CASE("a disk that fills up, refuses or lies ends the update, and what runs goes on", "[update]") {
  enum class Fault { full, broken, lying, unsynced };
  class BadDisk final : public hal::Disk {
   public:
    explicit BadDisk(Fault fault) : fault_(fault) {}
    ssize_t pwrite(int fd, const void* data, std::size_t size_bytes, off_t offset) override {
      const bool is_image = size_bytes > 4096;
      if (is_image && offset > 200'000 && fault_ == Fault::full) return errno = ENOSPC, -1;
      if (is_image && fault_ == Fault::broken) return errno = EIO, -1;
      std::vector<std::uint8_t> bytes(static_cast<const std::uint8_t*>(data),
                                      static_cast<const std::uint8_t*>(data) + size_bytes);
      if (is_image && offset > 200'000 && fault_ == Fault::lying) bytes[77] ^= 4U;
      return ::pwrite(fd, bytes.data(), bytes.size(), offset);
    }
    int fsync(int fd) override {
      if (::lseek(fd, 0, SEEK_END) > 100'000 && fault_ == Fault::unsynced) return errno = EIO, -1;
      return ::fsync(fd);
    }

   private:
    const Fault fault_;
  };
  const std::vector<std::pair<Fault, UpdateEnd>> faults{{Fault::full, UpdateEnd::disk_full},
                                                        {Fault::broken, UpdateEnd::disk_error},
                                                        {Fault::lying, UpdateEnd::read_back_differs},
                                                        {Fault::unsynced, UpdateEnd::disk_error}};
  for (const auto& [fault, end] : faults) {
    Bench bench;
    BadDisk bad(fault);
    {
      const hal::DiskInstead instead(bad);
      CHECK(bench.send().end == end);
    }
    bench.machine.check_runs_on();
    CHECK(bench.machine.book()[Slot::b].condition == SlotCondition::empty);
    CHECK(hal::plan_start(bench.machine.book())->slot == Slot::a);
    CHECK(bench.send().end == UpdateEnd::installed);
    bench.machine.check_installed(bench.manifest);
  }
}

TEST_CASE("whichever call to the disk is the last before the power goes, A runs on or B is whole", "[update]") {
  class LastCall final : public hal::Disk {
   public:
    explicit LastCall(int calls) : left_(calls) {}
    ssize_t pwrite(int fd, const void* data, std::size_t size_bytes, off_t offset) override {
      if (is_dead()) {
        // The one at which it goes is half done.
        if (left_ == -1) return ::pwrite(fd, data, size_bytes / 2, offset) < 0 ? -1 : (errno = EIO, -1);
        return errno = EIO, -1;
      }
      return ::pwrite(fd, data, size_bytes, offset);
    }
    int fsync(int fd) override { return is_dead() ? (errno = EIO, -1) : ::fsync(fd); }
    int ftruncate(int fd, off_t size_bytes) override {
      return is_dead() ? (errno = EIO, -1) : ::ftruncate(fd, size_bytes);
    }

   private:
    bool is_dead() { return --left_ < 0; }
    int left_;
  };
  int installed_at = 0;
  for (int calls = 0; installed_at == 0; ++calls) {
    REQUIRE(calls < 100);
    Bench bench;
    LastCall disk(calls);
    std::optional<UpdateEnd> end;
    {
      const hal::DiskInstead instead(disk);
      end = bench.send().end;
    }
    if (end == UpdateEnd::installed) installed_at = calls;
    const auto plan = hal::plan_start(bench.machine.book());
    REQUIRE(plan);
    if (plan->slot == Slot::b) bench.machine.check_installed(bench.manifest);
    bench.machine.check_runs_on();
    const auto again = bench.send().end;
    CHECK((again == UpdateEnd::installed || again == UpdateEnd::already_there));
    bench.machine.check_installed(bench.manifest);
  }
  CHECK(installed_at == 6 + 2 + 2);  // chunks, size and sync of the image, the book's record and its sync
}

TEST_CASE("chunks are asked for no faster than was said", "[update]") {
  Bench bench;
  bench.manifest = bench.machine.make_image(40 * kChunk_bytes, 6);
  bench.image = system_image(40 * kChunk_bytes, 6);
  TalkOptions options;
  options.rate_Bps = 10.0 * kChunk_bytes;
  const TalkResult result = bench.send(options);
  CHECK(result.end == UpdateEnd::installed);
  CHECK(result.took_ns >= 3'000 * hal::kMillisecond_ns);
  CHECK(result.took_ns <= 4'500 * hal::kMillisecond_ns);
}

TEST_CASE("one that is ended from outside says so and listens no more", "[update]") {
  Bench bench;
  UpdateTarget target(bench.machine.paths());
  UpdateIntake intake(bench.machine.key.update_key(), target, {1}, 1e9);
  CHECK(intake.waits_for_sender());
  CHECK(intake.wants().size() == kProof_bytes);
  intake.said(intake.says().size());
  intake.finish(UpdateEnd::too_slow);
  intake.finish(UpdateEnd::busy);
  CHECK(intake.end() == UpdateEnd::too_slow);
  CHECK(intake.wants().empty());
  CHECK_FALSE(intake.step(0));
  CHECK(intake.says().size() == kWord_bytes);
  CHECK_FALSE(intake.is_proved());
}
