// SPDX-License-Identifier: Apache-2.0
// `g3dmap tell`: one word to a robot that runs, and what it answers.
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

#include "hal/linux/control_socket.hpp"
#include "main_commands.hpp"

namespace g3d {

int run_tell(const TellOptions& options) {
  std::error_code ignored;
  const bool is_folder = std::filesystem::is_directory(options.path, ignored);
  const auto answer = hal::ask_control_socket(is_folder ? options.path + "/control" : options.path, options.word);
  if (!answer) {
    fmt::print(stderr, "g3dmap: {}\n", answer.error().text);
    return kExitFailed;
  }
  const bool is_refused = answer.value().find("\"error\"") != std::string::npos;
  fmt::print(is_refused ? stderr : stdout, "{}", answer.value());
  return is_refused ? kExitFailed : kExitDone;
}

}  // namespace g3d
