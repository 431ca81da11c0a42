// SPDX-License-Identifier: Apache-2.0
#include "nav/set_aside.hpp"

#include <algorithm>
#include <cstdlib>

namespace g3d::nav {
namespace {

constexpr std::size_t kMostClaimed = 16384;  // what fifteen robots see around them, twice

}  // namespace

void SetAside::reset(std::size_t targets, int max_tries, double rest_s) {
  max_tries_ = max_tries;
  rest_ns_ = static_cast<hal::TimeNs>(rest_s * 1e9);
  ignored_.assign(targets, 0);
  tries_.assign(targets, 0);
  resting_.clear();
  resting_.reserve(4096);
  claimed_.clear();
  claimed_.reserve(std::min(targets, kMostClaimed));
  place_count_ = 0;
}

void SetAside::target_failed(std::uint32_t target, Cause cause, hal::TimeNs now, int weight) {
  std::uint8_t& flags = ignored_[target];
  if ((flags & (kResting | kGivenUp)) != 0) return;
  flags = static_cast<std::uint8_t>((flags & kNotOurs) | (cause == Cause::blocked ? kBlocked : 0));
  tries_[target] = static_cast<std::uint8_t>(std::min(tries_[target] + weight, max_tries_));
  if (tries_[target] >= max_tries_) {
    flags |= kGivenUp;
    return;
  }
  flags |= kResting;
  resting_.push_back({target, now + (rest_ns_ << (tries_[target] - 1))});
}

void SetAside::place_failed(Cell place, hal::TimeNs now) {
  for (std::size_t i = 0; i < place_count_; ++i) {
    RestingPlace& p = places_[i];
    if (!(p.cell == place)) continue;
    p.tries = std::min(p.tries + 1, 6);
    p.until = now + (rest_ns_ << p.tries);
    return;
  }
  std::size_t at = place_count_;
  if (place_count_ < kMaxPlaces) {
    ++place_count_;
  } else {
    at = static_cast<std::size_t>(
        std::min_element(places_.begin(), places_.end(),
                         [](const RestingPlace& a, const RestingPlace& b) { return a.until < b.until; }) -
        places_.begin());
  }
  places_[at] = {place, now + rest_ns_, 0};
}

void SetAside::expire(hal::TimeNs now) {
  std::erase_if(resting_, [&](const RestingTarget& r) {
    if (r.until > now) return false;
    ignored_[r.target] &= static_cast<std::uint8_t>(~(kResting | kBlocked));
    return true;
  });
  for (std::size_t i = 0; i < place_count_; ++i) {
    if (places_[i].until <= now) places_[i].until = 0;
  }
}

void SetAside::forgive_blocked() {
  for (std::size_t i = 0; i < ignored_.size(); ++i) {
    if ((ignored_[i] & kBlocked) == 0) continue;
    ignored_[i] &= kNotOurs;
    tries_[i] = 0;
  }
  std::erase_if(resting_, [&](const RestingTarget& r) { return (ignored_[r.target] & kResting) == 0; });
  place_count_ = 0;
}

bool SetAside::wake_all() {
  bool any = false;
  for (const RestingTarget& r : resting_) {
    ignored_[r.target] &= static_cast<std::uint8_t>(~(kResting | kBlocked));
    any = true;
  }
  resting_.clear();
  return any;
}

void SetAside::claim(std::uint32_t target) {
  if (is_claimed(target) || claimed_.size() == claimed_.capacity()) return;
  ignored_[target] |= kClaimed;
  claimed_.push_back(target);
}

bool SetAside::forget_claims() {
  bool any = false;
  for (const std::uint32_t target : claimed_) {
    any = any || is_claimed(target);
    unclaim(target);
  }
  claimed_.clear();
  return any;
}

bool SetAside::is_place_resting(Cell place, int radius_cells) const {
  return std::any_of(places_.begin(), places_.begin() + static_cast<std::ptrdiff_t>(place_count_),
                     [&](const RestingPlace& p) {
                       return p.until != 0 && std::abs(p.cell.x - place.x) <= radius_cells &&
                              std::abs(p.cell.y - place.y) <= radius_cells;
                     });
}

}  // namespace g3d::nav
