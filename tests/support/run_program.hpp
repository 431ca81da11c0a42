// SPDX-License-Identifier: Apache-2.0
// Runs a program as a user would and keeps what it said.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace g3d::test {

struct ProgramResult {
  int exit_code = -1;  ///< -1: killed by a signal or by the time limit
  int signal = 0;      ///< the signal that killed it
  bool timed_out = false;
  std::string out;  ///< standard output
  std::string err;  ///< standard error
};

/// What a program is not allowed to do.
struct Confinement {
  bool no_root = false;               ///< runs as nobody if this process is root: root may write everywhere
  std::uint64_t file_size_bytes = 0;  ///< no file may grow beyond this; 0: any may
};

/// A started program; one that still runs at the end of its scope is killed.
class Program {
 public:
  /// `arguments` without the program's name.
  Program(const std::string& path, const std::vector<std::string>& arguments, const Confinement& confinement = {});
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void send(int signal) const;
  [[nodiscard]] pid_t pid() const { return pid_; }
  [[nodiscard]] bool is_running();
  /// Waits for the end; kills the program after `limit`.
  ProgramResult finish(std::chrono::milliseconds limit = std::chrono::seconds(60));

 private:
  pid_t pid_ = -1;
  int status_ = 0;
  bool reaped_ = false;
  std::string out_path_;
  std::string err_path_;
};

/// The program under test, from the environment variable G3DMAP_EXE; build/host/g3dmap without it.
[[nodiscard]] std::string g3dmap_path();
ProgramResult run_g3dmap(const std::vector<std::string>& arguments, const Confinement& confinement = {});

}  // namespace g3d::test
