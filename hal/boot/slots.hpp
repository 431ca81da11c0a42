// SPDX-License-Identifier: Apache-2.0
// Two places for the system, A and B: one runs while the other is written, and one that does not come up is left again.
// The boot loader of a TX2 (CBoot, U-Boot, extlinux) counts nothing and chooses nothing: it starts one kernel with one
// initramfs. So kernel and initramfs are never replaced over the network, and the first process in that initramfs
// decides, by this book, whose system it goes on with:
//
//   plan_start() -> keep the plan's book on disk -> start plan.slot -> healthy for a while -> started_well()
//                                                         \-> cannot be mounted: cannot_start(), plan_start()
//
// A start is counted before it is tried, so that a hang or a power cut counts too. Pure functions on plain values, any
// thread; slot_store.hpp keeps the book.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "hal/messages.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

enum class Slot : std::uint8_t { a = 0, b = 1 };
inline constexpr std::size_t kSlotCount = 2;
[[nodiscard]] constexpr Slot other_slot(Slot slot) { return slot == Slot::a ? Slot::b : Slot::a; }
[[nodiscard]] constexpr const char* to_string(Slot slot) { return slot == Slot::a ? "a" : "b"; }

enum class SlotCondition : std::uint8_t {
  empty = 0,    ///< nothing, or something half written: never started
  untried = 1,  ///< whole, but has not yet shown that it comes up
  good = 2,     ///< was healthy once
  bad = 3,      ///< did not come up; started only if there is nothing else
};
[[nodiscard]] const char* to_string(SlotCondition condition);

/// So many starts without health, and an untried system is left for the good one.
inline constexpr std::uint8_t kMostFailedStarts = 3;

using ImageDigest = std::array<std::uint8_t, 32>;  ///< BLAKE2b-256 of the image's bytes

/// What is known of an image; size 0: nothing is, as for one that somebody put there by hand.
struct SlotImageId {
  std::uint64_t release = 0;  ///< later ones have larger numbers
  std::uint64_t size_bytes = 0;
  ImageDigest digest{};
  bool operator==(const SlotImageId&) const = default;
};

struct SlotEntry {
  SlotCondition condition = SlotCondition::empty;
  std::uint8_t starts = 0;   ///< since it was written, without health so far; counts while untried
  bool may_go_back = false;  ///< the key's holder wanted this release even if it is an older one
  SlotImageId image;
  bool operator==(const SlotEntry&) const = default;
};

struct SlotBook {
  std::array<SlotEntry, kSlotCount> entries;
  Slot preferred = Slot::a;
  std::uint64_t newest_good_release = 0;  ///< an older one is refused unless it may go back

  [[nodiscard]] SlotEntry& operator[](Slot slot) { return entries[static_cast<std::size_t>(slot)]; }
  [[nodiscard]] const SlotEntry& operator[](Slot slot) const { return entries[static_cast<std::size_t>(slot)]; }
  bool operator==(const SlotBook&) const = default;
};

/// The book of a machine that was just flashed: A is taken for good, as nothing else is there.
[[nodiscard]] SlotBook first_book(const SlotImageId& image_a);
/// The book where none can be read: either may hold something, and both are tried in turn, A first.
[[nodiscard]] SlotBook lost_book();

/// Slots that cannot be started in this very boot: no such file, wrong digest, cannot be mounted.
struct UnusableSlots {
  std::array<bool, kSlotCount> is_unusable{};
  void add(Slot slot) { is_unusable[static_cast<std::size_t>(slot)] = true; }
  [[nodiscard]] bool has(Slot slot) const { return is_unusable[static_cast<std::size_t>(slot)]; }
};

struct StartPlan {
  Slot slot = Slot::a;
  SlotBook book;                 ///< to be on disk before that slot is started
  std::optional<Slot> given_up;  ///< the slot that this plan has marked bad after too many starts
};

/// None if neither can be started: then what the initramfs carries runs, and waits for an update.
[[nodiscard]] std::optional<StartPlan> plan_start(const SlotBook& book, const UnusableSlots& unusable = {});
/// The slot that runs has been healthy for long enough (HealthTrial): it is good, and its release may not go back.
[[nodiscard]] SlotBook started_well(SlotBook book, Slot running);
/// Its image is damaged or cannot be mounted.
[[nodiscard]] SlotBook cannot_start(SlotBook book, Slot slot);

/// Before the first byte of the slot that does not run is overwritten. `running`: none if the initramfs itself runs.
/// Errors: no_permission, while what runs is untried and the other slot is the only one known to be good.
[[nodiscard]] Result<SlotBook> begin_writing(SlotBook book, std::optional<Slot> running, Slot target);
/// Where an update goes: the slot that does not run; without one, the worse of the two.
[[nodiscard]] Slot slot_for_update(const SlotBook& book, std::optional<Slot> running);
/// The slot holds that image, read back from the disk: it is next. From begin_writing(...) on that slot alone.
[[nodiscard]] SlotBook finish_writing(SlotBook book, Slot target, const SlotImageId& image, bool may_go_back);

/// Health without a break for `needed_ns`; then true for ever. The caller says what health is, such as frames that go
/// into the map.
class HealthTrial {
 public:
  static constexpr TimeNs kUsual_ns = 30'000 * kMillisecond_ns;
  explicit HealthTrial(TimeNs needed_ns = kUsual_ns) : needed_ns_(needed_ns) {}
  [[nodiscard]] bool note(TimeNs now_ns, bool is_healthy);

 private:
  TimeNs needed_ns_;
  std::optional<TimeNs> since_ns_;
  bool is_passed_ = false;
};

}  // namespace g3d::hal
