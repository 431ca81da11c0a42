// SPDX-License-Identifier: Apache-2.0
#include "tests/support/run_program.hpp"

#include <fcntl.h>
#include <grp.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <thread>

namespace g3d::test {
namespace {

std::string new_temporary_file() {
  std::string path = "/tmp/g3dmap_test_XXXXXX";
  const int fd = mkstemp(path.data());
  if (fd < 0) throw std::runtime_error("cannot create a temporary file in /tmp");
  close(fd);
  return path;
}

std::string read_and_remove(const std::string& path) {
  std::string text;
  if (std::FILE* file = std::fopen(path.c_str(), "rb")) {
    char buffer[4096];
    for (std::size_t n = std::fread(buffer, 1, sizeof buffer, file); n > 0;
         n = std::fread(buffer, 1, sizeof buffer, file)) {
      text.append(buffer, n);
    }
    std::fclose(file);
  }
  std::remove(path.c_str());
  return text;
}

/// In the child, before exec.
bool confine(const Confinement& confinement) {
  if (confinement.file_size_bytes > 0) {
    const rlimit limit{confinement.file_size_bytes, confinement.file_size_bytes};
    std::signal(SIGXFSZ, SIG_IGN);  // then write() fails with EFBIG
    if (setrlimit(RLIMIT_FSIZE, &limit) != 0) return false;
  }
  constexpr id_t kNobody = 65534;
  if (!confinement.no_root || geteuid() != 0) return true;
  return setgroups(0, nullptr) == 0 && setgid(kNobody) == 0 && setuid(kNobody) == 0;
}

}  // namespace

Program::Program(const std::string& path, const std::vector<std::string>& arguments, const Confinement& confinement)
    : out_path_(new_temporary_file()), err_path_(new_temporary_file()) {
  std::vector<char*> argv{const_cast<char*>(path.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("cannot fork");
  if (pid_ == 0) {
    // Only calls that are safe after fork() in a process with threads.
    dup2(open("/dev/null", O_RDONLY), STDIN_FILENO);
    dup2(open(out_path_.c_str(), O_WRONLY | O_TRUNC), STDOUT_FILENO);
    dup2(open(err_path_.c_str(), O_WRONLY | O_TRUNC), STDERR_FILENO);
    // Opened before the rights go: nobody may have no way into the folder where the program lies.
    const int program = open(argv[0], O_RDONLY | O_CLOEXEC);
    if (!confine(confinement)) _exit(126);
    fexecve(program, argv.data(), environ);
    _exit(127);
  }
}

Program::~Program() {
  if (!reaped_) (void)finish(std::chrono::milliseconds(0));
}

void Program::send(int signal) const { kill(pid_, signal); }

bool Program::is_running() {
  if (!reaped_ && waitpid(pid_, &status_, WNOHANG) == pid_) reaped_ = true;
  return !reaped_;
}

ProgramResult Program::finish(std::chrono::milliseconds limit) {
  ProgramResult result;
  const auto end = std::chrono::steady_clock::now() + limit;
  while (is_running()) {
    if (std::chrono::steady_clock::now() >= end) {
      result.timed_out = true;
      kill(pid_, SIGKILL);
      waitpid(pid_, &status_, 0);
      reaped_ = true;
      break;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  if (WIFEXITED(status_)) result.exit_code = WEXITSTATUS(status_);
  if (WIFSIGNALED(status_)) result.signal = WTERMSIG(status_);
  result.out = read_and_remove(out_path_);
  result.err = read_and_remove(err_path_);
  return result;
}

std::string g3dmap_path() {
  const char* path = std::getenv("G3DMAP_EXE");
  return path != nullptr && *path != '\0' ? path : "build/host/g3dmap";
}

ProgramResult run_g3dmap(const std::vector<std::string>& arguments, const Confinement& confinement) {
  return Program(g3dmap_path(), arguments, confinement).finish();
}

}  // namespace g3d::test
