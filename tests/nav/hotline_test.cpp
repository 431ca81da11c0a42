// SPDX-License-Identifier: Apache-2.0
#include "nav/hotline.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <thread>

using namespace g3d;
using namespace g3d::nav;

TEST_CASE("words come out in the order in which they were said, and a full line refuses") {
  Hotline hotline;
  CHECK_FALSE(hotline.take().has_value());
  CHECK(hotline.say(PersonWord::pause));
  CHECK(hotline.say(PersonWord::home));
  CHECK(hotline.take() == PersonWord::pause);
  CHECK(hotline.take() == PersonWord::home);
  int taken = 0;
  while (hotline.say(PersonWord::stop)) ++taken;
  CHECK(taken == 16);
  CHECK(hotline.refused_words() == 1);
  CHECK(hotline.said(PersonWord::stop) == 16);
  CHECK(hotline.answer("stop").find("too many") != std::string::npos);
}

TEST_CASE("what is no word is refused and counted, whatever the bytes") {
  Hotline hotline;
  for (const std::string& text : {std::string("dance"), std::string(1'000, '\0'), std::string("pause now")}) {
    CHECK(hotline.answer(text).find("\"error\"") != std::string::npos);
  }
  CHECK(hotline.unknown_words() == 3);
  CHECK_FALSE(hotline.take().has_value());
}

TEST_CASE("an answer waits until the robot has taken the word, and tells how it is then", "[threads]") {
  Hotline hotline;
  std::atomic<bool> is_over{false};
  std::thread navigator([&] {
    MissionState state = MissionState::exploring;
    while (!is_over.load()) {
      if (hotline.take()) state = MissionState::paused;
      LiveStatus status;
      status.state = state;
      hotline.publish(status);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  });
  for (int i = 0; i < 5; ++i) CHECK(hotline.answer("pause").find("\"state\": \"paused\"") != std::string::npos);
  CHECK(hotline.answer("status").find("\"state\": \"paused\"") != std::string::npos);
  is_over = true;
  navigator.join();
  CHECK(hotline.answer("resume").find("0.5 s") != std::string::npos);  // nobody takes it any more
}
