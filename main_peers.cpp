// SPDX-License-Identifier: Apache-2.0
// `g3dmap peers`: asks a program that runs who knows what in its fleet.
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

#include "hal/linux/control_socket.hpp"
#include "main_commands.hpp"
#include "main_say.hpp"

namespace g3d {

int run_peers(const PeersOptions& options) {
  std::error_code ignored;
  const bool is_folder = std::filesystem::is_directory(options.path, ignored);
  const auto answer = hal::ask_control_socket(is_folder ? options.path + "/control" : options.path,
                                              options.json ? "peers" : "peers text");
  if (!answer) return fail(answer.error().text);
  const bool is_refused = answer.value().starts_with("{\"error\"") || answer.value().starts_with("{\n  \"error\"");
  fmt::print(is_refused ? stderr : stdout, "{}", answer.value());
  return is_refused ? kExitFailed : kExitDone;
}

}  // namespace g3d
