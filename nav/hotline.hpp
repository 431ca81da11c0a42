// SPDX-License-Identifier: Apache-2.0
// Between people and the thread that owns the navigator. People's words wait in a ring until that thread takes them,
// and it leaves its status in a slot; it never waits for anybody. answer() is the other end of the control socket: any
// bytes in, one JSON object out.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "hal/latest.hpp"
#include "hal/ring.hpp"
#include "nav/live_status.hpp"
#include "nav/person_word.hpp"

namespace g3d::nav {

class Hotline {
 public:
  // The navigator's thread
  [[nodiscard]] std::optional<PersonWord> take();
  void publish(LiveStatus status);

  // Any other thread
  [[nodiscard]] const hal::Latest<LiveStatus>& status() const { return status_; }
  /// False if too many words wait.
  bool say(PersonWord word);
  /// Waits for the word to be taken, but no longer than half a second. What is no word is refused and counted.
  [[nodiscard]] std::string answer(std::string_view request);
  [[nodiscard]] std::uint64_t said(PersonWord word) const {
    return said_[static_cast<std::size_t>(word)].load(std::memory_order_relaxed);
  }
  [[nodiscard]] std::uint64_t unknown_words() const { return unknown_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t refused_words() const { return refused_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::size_t kWaiting = 16;

  std::mutex saying_;  // among those who speak; who takes needs it not
  hal::Ring<PersonWord> words_{kWaiting};
  std::uint64_t said_in_all_ = 0;  // under saying_
  std::uint64_t taken_ = 0;        // the navigator's thread
  hal::Latest<LiveStatus> status_;
  std::array<std::atomic<std::uint64_t>, static_cast<std::size_t>(PersonWord::count_)> said_{};
  std::atomic<std::uint64_t> unknown_{0}, refused_{0};
};

}  // namespace g3d::nav
