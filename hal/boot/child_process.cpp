// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/child_process.hpp"

#include <errno.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <utility>

#include "hal/image/atomic_file.hpp"

namespace g3d::hal::boot {
namespace {

constexpr std::size_t kMostOutputLine_bytes = 1000;
constexpr int kCannotExecute = 127;

std::vector<char*> pointers(std::vector<std::string>& words) {
  std::vector<char*> list;
  for (std::string& word : words) list.push_back(word.data());
  list.push_back(nullptr);
  return list;
}

}  // namespace

ChildProcess::~ChildProcess() { close_pipes(); }

void ChildProcess::close_pipes() {
  for (int* const fd : {&output_fd_, &input_fd_}) {
    if (*fd >= 0) ::close(std::exchange(*fd, -1));
  }
}

Result<void> ChildProcess::start(const Command& command) {
  close_pipes();
  line_.clear();
  std::array<int, 4> ends = {-1, -1, -1, -1};  // of what it says, then of what it reads
  const auto fail = [&](std::string_view what) {
    const int problem = errno;
    for (const int fd : ends) ::close(fd);
    return system_error(command.program, what, problem);
  };
  if (::pipe2(ends.data(), O_CLOEXEC) != 0 || ::pipe2(ends.data() + 2, O_CLOEXEC) != 0) return fail("gets no pipe");
  std::vector<std::string> words{command.program};
  words.insert(words.end(), command.arguments.begin(), command.arguments.end());
  std::vector<std::string> environment = command.environment;
  const std::vector<char*> argv = pointers(words);
  const std::vector<char*> envp = pointers(environment);
  const pid_t child = ::fork();
  if (child < 0) return fail("cannot be started");
  if (child == 0) {
    sigset_t none;
    ::sigemptyset(&none);
    ::sigprocmask(SIG_SETMASK, &none, nullptr);
    ::setsid();
    ::dup2(ends[2], 0);
    ::dup2(ends[1], 1);
    ::dup2(ends[1], 2);
    ::execve(argv[0], argv.data(), envp.data());
    ::_exit(kCannotExecute);
  }
  ::close(ends[1]);
  ::close(ends[2]);
  output_fd_ = ends[0];
  input_fd_ = ends[3];
  for (const int fd : {output_fd_, input_fd_}) (void)::fcntl(fd, F_SETFL, O_NONBLOCK);
  pid_ = child;
  return {};
}

void ChildProcess::read_lines(const std::function<void(std::string_view)>& take) {
  std::array<char, 4096> bytes{};
  while (output_fd_ >= 0) {
    const ssize_t size = ::read(output_fd_, bytes.data(), bytes.size());
    if (size == 0) ::close(std::exchange(output_fd_, -1));  // nobody can say anything any more
    if (size <= 0) return;
    for (const char c : std::string_view(bytes.data(), static_cast<std::size_t>(size))) {
      // A line that is written over itself, as progress is, counts as many.
      const bool is_end = c == '\n' || c == '\r';
      if (!is_end) line_ += c >= ' ' && c <= '~' ? c : '?';
      if ((is_end && !line_.empty()) || line_.size() >= kMostOutputLine_bytes) {
        take(line_);
        line_.clear();
      }
    }
  }
}

void ChildProcess::type(std::string_view line) {
  const std::string text = std::string(line) + "\n";
  if (input_fd_ >= 0) (void)!::write(input_fd_, text.data(), text.size());
}

void ChildProcess::on_end(const std::function<void(std::string_view)>& take) {
  read_lines(take);
  if (!line_.empty()) take(line_);
  line_.clear();
  close_pipes();
  pid_ = -1;
}

std::optional<ProcessEnd> end_of(int wait_status) {
  if (WIFEXITED(wait_status)) return ProcessEnd{WEXITSTATUS(wait_status), 0};
  if (WIFSIGNALED(wait_status)) return ProcessEnd{0, WTERMSIG(wait_status)};
  return std::nullopt;
}

std::string to_text(const ProcessEnd& end) {
  if (end.signal == 0) return fmt::format("exit code {}", end.exit_code);
  const char* const name = ::sigdescr_np(end.signal);
  return fmt::format("signal {} ({})", end.signal, name != nullptr ? name : "?");
}

}  // namespace g3d::hal::boot
