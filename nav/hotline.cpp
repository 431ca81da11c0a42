// SPDX-License-Identifier: Apache-2.0
#include "nav/hotline.hpp"

#include <chrono>
#include <thread>

#include "mapper/json_writer.hpp"

namespace g3d::nav {
namespace {

constexpr auto kPatience = std::chrono::milliseconds(500);
constexpr auto kLook = std::chrono::milliseconds(2);

std::string refusal(const char* text) {
  mapper::JsonWriter json;
  json.begin_object().member("error", text).end_object();
  return json.take();
}

}  // namespace

std::optional<PersonWord> Hotline::take() {
  PersonWord word{};
  if (!words_.try_pop(word)) return std::nullopt;
  ++taken_;
  return word;
}

void Hotline::publish(LiveStatus status) {
  status.words = taken_;
  status_.write(status);
}

bool Hotline::say(PersonWord word) {
  const std::lock_guard lock(saying_);
  if (!words_.try_push(word)) {
    refused_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  ++said_in_all_;
  said_[static_cast<std::size_t>(word)].fetch_add(1, std::memory_order_relaxed);
  return true;
}

std::string Hotline::answer(std::string_view request) {
  const auto word = parse_word(request);
  if (!word) {
    unknown_.fetch_add(1, std::memory_order_relaxed);
    return refusal("no such word; say pause, resume, stop, home or status");
  }
  LiveStatus status;
  if (*word == PersonWord::status) {
    said_[static_cast<std::size_t>(*word)].fetch_add(1, std::memory_order_relaxed);
    (void)status_.read(status);
    return to_json(status);
  }
  if (!say(*word)) return refusal("too many words wait for the robot; say it again");
  std::uint64_t number = 0;
  {
    const std::lock_guard lock(saying_);
    number = said_in_all_;
  }
  const auto until = std::chrono::steady_clock::now() + kPatience;
  while (status_.read(status) == 0 || status.words < number) {
    if (std::chrono::steady_clock::now() >= until) {
      return refusal("heard, but the robot has not answered within 0.5 s; ask for its status");
    }
    std::this_thread::sleep_for(kLook);
  }
  return to_json(status);
}

}  // namespace g3d::nav
