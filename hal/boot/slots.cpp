// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/slots.hpp"

#include <algorithm>

namespace g3d::hal {
namespace {

bool is_out_of_starts(const SlotEntry& entry) {
  return entry.condition == SlotCondition::untried && entry.starts >= kMostFailedStarts;
}

bool is_worth_a_start(const SlotBook& book, Slot slot, const UnusableSlots& unusable) {
  const SlotCondition condition = book[slot].condition;
  return !unusable.has(slot) && (condition == SlotCondition::good || condition == SlotCondition::untried);
}

}  // namespace

const char* to_string(SlotCondition condition) {
  switch (condition) {
    case SlotCondition::empty:
      return "empty";
    case SlotCondition::untried:
      return "untried";
    case SlotCondition::good:
      return "good";
    case SlotCondition::bad:
      return "bad";
  }
  return "unknown";
}

SlotBook first_book(const SlotImageId& image_a) {
  SlotBook book;
  book[Slot::a].condition = SlotCondition::good;
  book[Slot::a].image = image_a;
  book.newest_good_release = image_a.release;
  return book;
}

SlotBook lost_book() {
  SlotBook book;
  for (SlotEntry& entry : book.entries) entry.condition = SlotCondition::untried;
  return book;
}

std::optional<StartPlan> plan_start(const SlotBook& book, const UnusableSlots& unusable) {
  StartPlan plan{book.preferred, book, std::nullopt};
  SlotBook& next = plan.book;
  const Slot first = book.preferred;
  const Slot second = other_slot(first);
  if (is_out_of_starts(next[first]) && is_worth_a_start(next, second, unusable)) {
    // Only what is known to be good makes the other one bad; two that are untried take turns.
    if (next[second].condition == SlotCondition::good) {
      next[first].condition = SlotCondition::bad;
      plan.given_up = first;
    }
    next[first].starts = 0;
    next.preferred = second;
  }
  const std::array<Slot, kSlotCount> order{next.preferred, other_slot(next.preferred)};
  auto chosen =
      std::find_if(order.begin(), order.end(), [&](Slot slot) { return is_worth_a_start(next, slot, unusable); });
  if (chosen == order.end()) {
    chosen = std::find_if(order.begin(), order.end(),
                          [&](Slot slot) { return !unusable.has(slot) && next[slot].condition == SlotCondition::bad; });
  }
  if (chosen == order.end()) return std::nullopt;
  plan.slot = *chosen;
  SlotEntry& entry = next[plan.slot];
  if (entry.condition == SlotCondition::untried && entry.starts < kMostFailedStarts) ++entry.starts;
  return plan;
}

SlotBook started_well(SlotBook book, Slot running) {
  SlotEntry& entry = book[running];
  if (entry.condition == SlotCondition::empty) return book;  // somebody has begun to overwrite it
  const bool was_good = entry.condition == SlotCondition::good;
  entry.condition = SlotCondition::good;
  entry.starts = 0;
  if (!was_good) {
    book.newest_good_release =
        entry.may_go_back ? entry.image.release : std::max(book.newest_good_release, entry.image.release);
  }
  return book;
}

SlotBook cannot_start(SlotBook book, Slot slot) {
  SlotEntry& entry = book[slot];
  const Slot second = other_slot(slot);
  if (entry.condition == SlotCondition::good) {
    // A disk that failed once may answer at the next boot; so it is not condemned, but no longer relied upon.
    entry.condition = SlotCondition::untried;
    entry.starts = 0;
  } else if (entry.condition == SlotCondition::untried && book[second].condition == SlotCondition::good) {
    entry.condition = SlotCondition::bad;
    entry.starts = 0;
  }
  if (book[second].condition == SlotCondition::good) book.preferred = second;
  return book;
}

Result<SlotBook> begin_writing(SlotBook book, std::optional<Slot> running, Slot target) {
  if (running == target) {
    return Error{Reason::bad_usage, std::string("slot ") + to_string(target) +
                                        ": the system that runs is there; an update goes into the other one"};
  }
  const bool keeps_good = book[other_slot(target)].condition == SlotCondition::good;
  if (book[target].condition == SlotCondition::good && !keeps_good) {
    return Error{Reason::no_permission, std::string("slot ") + to_string(target) +
                                            ": holds the only system that is known to come up; wait until the one "
                                            "that runs has been healthy for a while"};
  }
  book[target] = SlotEntry{};
  book.preferred = other_slot(target);
  return book;
}

Slot slot_for_update(const SlotBook& book, std::optional<Slot> running) {
  if (running) return other_slot(*running);
  const auto worth = [&book](Slot slot) {
    const SlotCondition condition = book[slot].condition;
    return condition == SlotCondition::good      ? 3
           : condition == SlotCondition::untried ? 2
                                                 : condition == SlotCondition::bad;
  };
  return worth(Slot::b) <= worth(Slot::a) ? Slot::b : Slot::a;
}

SlotBook finish_writing(SlotBook book, Slot target, const SlotImageId& image, bool may_go_back) {
  book[target] = {SlotCondition::untried, 0, may_go_back, image};
  book.preferred = target;
  return book;
}

bool HealthTrial::note(TimeNs now_ns, bool is_healthy) {
  if (is_passed_) return true;
  if (!is_healthy) {
    since_ns_.reset();
    return false;
  }
  if (!since_ns_ || now_ns < *since_ns_) since_ns_ = now_ns;
  is_passed_ = now_ns - *since_ns_ >= needed_ns_;
  return is_passed_;
}

}  // namespace g3d::hal
