// SPDX-License-Identifier: Apache-2.0
// What every command says when it cannot go on; the exit code comes along.
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string>

#include "hal/result.hpp"
#include "main_commands.hpp"

namespace g3d {

inline int fail(const std::string& text, int exit_code = kExitFailed) {
  fmt::print(stderr, "g3dmap: {}\n", text);
  return exit_code;
}

inline int bad_usage(const std::string& text) { return fail(text, kExitBadUsage); }

/// The exit code as the error's reason has it.
inline int fail_as(const hal::Error& error) {
  return fail(error.text, error.reason == hal::Reason::bad_usage ? kExitBadUsage : kExitFailed);
}

}  // namespace g3d
