// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/frozen_thread.hpp"

#include <errno.h>
#include <fmt/format.h>
#include <sys/ptrace.h>

#include <charconv>
#include <filesystem>
#include <fstream>

#include "hal/image/atomic_file.hpp"

namespace g3d::hal::boot {

std::vector<ThreadName> threads_of(pid_t process) {
  std::vector<ThreadName> threads;
  std::error_code code;
  const std::string folder = fmt::format("/proc/{}/task", process);
  for (std::filesystem::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code)) {
    ThreadName thread;
    const std::string id = entry->path().filename().string();
    (void)std::from_chars(id.data(), id.data() + id.size(), thread.id);
    std::ifstream file(entry->path() / "comm");
    std::getline(file, thread.name);
    threads.push_back(thread);
  }
  return threads;
}

Result<void> freeze_thread(pid_t process, std::string_view name) {
  std::string names;
  for (const ThreadName& thread : threads_of(process)) {
    names += " " + thread.name;
    if (thread.name != name && fmt::format("{}", thread.id) != name) continue;
    if (::ptrace(PTRACE_SEIZE, thread.id, nullptr, nullptr) != 0 ||
        ::ptrace(PTRACE_INTERRUPT, thread.id, nullptr, nullptr) != 0) {
      return system_error(thread.name, "cannot be stopped", errno);
    }
    return {};
  }
  return Error{Reason::not_found, fmt::format("process {} has no thread '{}'; it has:{}", process, name, names)};
}

}  // namespace g3d::hal::boot
