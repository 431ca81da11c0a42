// SPDX-License-Identifier: Apache-2.0
// A program that the first process starts and looks after: what it says comes through a pipe, line by line, and how it
// has ended is told by whoever reaps. One thread.
#pragma once

#include <sys/types.h>

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/boot/restart_policy.hpp"
#include "hal/result.hpp"

namespace g3d::hal::boot {

class ChildProcess {
 public:
  struct Command {
    std::string program;
    std::vector<std::string> arguments;    ///< without the program's name
    std::vector<std::string> environment;  ///< KEY=VALUE, all there is
  };
  ChildProcess() = default;
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// In a session of its own, with nothing open but two pipes. Errors: io_error; that the program cannot
  /// be executed shows in its end: exit code 127.
  [[nodiscard]] Result<void> start(const Command& command);
  [[nodiscard]] pid_t pid() const { return pid_; }
  [[nodiscard]] bool is_running() const { return pid_ > 0; }
  /// Readable when it has said something; -1: nobody is there.
  [[nodiscard]] int output_fd() const { return output_fd_; }
  /// A line for it to read, without its end; thrown away if it does not take it at once.
  void type(std::string_view line);
  /// Hands over what came, whole lines; one longer than 1000 bytes in pieces. Does not wait.
  void read_lines(const std::function<void(std::string_view)>& take);
  /// From waitpid: it has ended. What it has said last is handed over.
  void on_end(const std::function<void(std::string_view)>& take);

 private:
  void close_pipes();
  pid_t pid_ = -1;
  int output_fd_ = -1;
  int input_fd_ = -1;
  std::string line_;
};

/// What waitpid says of a process that has ended; nothing if it has only stopped.
[[nodiscard]] std::optional<ProcessEnd> end_of(int wait_status);
/// "exit code 1", "signal 9 (Killed)".
[[nodiscard]] std::string to_text(const ProcessEnd& end);

}  // namespace g3d::hal::boot
