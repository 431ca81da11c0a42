// SPDX-License-Identifier: Apache-2.0
// What a person at the console, the serial line or the screen of the machine, may say to the first process.
#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <sstream>
#include <utility>

#include "hal/boot/frozen_thread.hpp"
#include "hal/linux/control_socket.hpp"
#include "main_init.hpp"

namespace g3d::init {
namespace {

constexpr std::size_t kMostLine_bytes = 200;
constexpr std::size_t kTail_bytes = 4000;
constexpr int kPatience_ms = 1000;  // less than any watchdog's
constexpr const char* kHelp =
    "status | log | tell WORD (pause resume stop home status) | restart | reboot | poweroff | hang THREAD | "
    "run ARGUMENTS (of g3dmap, beside the robot) | type LINE (to that) | end (that)";

}  // namespace

void Supervisor::on_console() {
  std::array<char, 256> bytes{};
  for (;;) {
    const ssize_t size = ::read(STDIN_FILENO, bytes.data(), bytes.size());
    if (size == 0) console_is_gone_ = true;
    if (size <= 0) return;
    for (const char c : std::string_view(bytes.data(), static_cast<std::size_t>(size))) {
      if (c != '\n' && c != '\r') {
        if (c >= ' ' && c <= '~' && console_line_.size() < kMostLine_bytes) console_line_ += c;
        continue;
      }
      const std::string line = std::exchange(console_line_, {});
      if (!line.empty()) obey(line);
    }
  }
}

void Supervisor::obey(const std::string& line) {
  const std::size_t space = std::min(line.find(' '), line.size());
  const std::string word = line.substr(0, space);
  const std::string rest = line.substr(std::min(space + 1, line.size()));
  if (word == "status") {
    machine_.speaker.say(status_text());
  } else if (word == "log") {
    const std::string tail = machine_.speaker.log().tail(kTail_bytes);
    (void)!::write(STDOUT_FILENO, tail.data(), tail.size());
  } else if (word == "tell") {
    tell_robot(rest);
  } else if (word == "run") {
    run_beside(rest);
  } else if (word == "type") {
    aside_.type(rest);
  } else if (word == "end") {
    if (aside_.is_running()) (void)::kill(aside_.pid(), SIGTERM);
  } else if (word == "restart") {
    start_again_ns_ = clock_.now();
    if (robot_.is_running()) (void)::kill(robot_.pid(), SIGTERM);
  } else if (word == "reboot") {
    end_with(End::reboot);
  } else if (word == "poweroff") {
    end_with(End::power_off);
  } else if (word == "hang" && robot_.is_running()) {
    // To see what happens then: the line guard, the watchdog, the start after it.
    const auto frozen = hal::boot::freeze_thread(robot_.pid(), rest);
    machine_.speaker.say(frozen ? fmt::format("the robot's thread {} hangs", rest) : frozen.error().text);
  } else {
    machine_.speaker.say(kHelp);
  }
}

void Supervisor::run_beside(const std::string& words) {
  if (aside_.is_running()) return machine_.speaker.say("something runs beside the robot already; end it first");
  hal::boot::ChildProcess::Command command{machine_.program, {}, {"PATH=/system", "HOME=/data"}};
  std::istringstream stream(words);
  for (std::string one; stream >> one;) command.arguments.push_back(one);
  if (const auto started = aside_.start(command); !started) machine_.speaker.say(started.error().text);
}

std::string Supervisor::robot_folder() const {
  const std::vector<std::string>& arguments = machine_.config.arguments;
  const auto found = std::find(arguments.begin(), arguments.end(), "--out");
  return found == arguments.end() || found + 1 == arguments.end() ? "" : *(found + 1);
}

void Supervisor::tell_robot(const std::string& word) {
  const auto answer = hal::ask_control_socket(robot_folder() + "/control", word, kPatience_ms);
  // What it answers is laid out in lines; here it is one.
  std::istringstream words(answer ? answer.value() : answer.error().text);
  std::string line;
  for (std::string one; words >> one;) line += (line.empty() ? "" : " ") + one;
  machine_.speaker.pass_on("robot", line);
}

std::string Supervisor::status_text() const {
  return fmt::format(
      "robot {}, started {} times, {} bad ends; system {}{}; network {}; watchdog {}; {} lines of the log lost",
      to_string(health_.state(clock_.now())), starts_, restarts_.ends(),
      machine_.slot ? to_string(*machine_.slot) : "of the boot image", machine_.is_on_trial ? " on trial" : "",
      address_ ? hal::boot::ipv4_text(*address_) : "without an address",
      machine_.watchdog.is_open() ? "open" : "missing", machine_.speaker.log().lost_lines());
}

}  // namespace g3d::init
