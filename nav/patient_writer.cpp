// SPDX-License-Identifier: Apache-2.0
#include "nav/patient_writer.hpp"

#include <algorithm>
#include <filesystem>
#include <optional>

namespace g3d::nav {
namespace {

constexpr hal::TimeNs kAgain_ns = 1'000'000'000;
constexpr hal::TimeNs kLook_ns = 50'000'000;  // for a person who gives up

bool may_pass(const hal::Error& error) {
  switch (error.reason) {
    case hal::Reason::not_found:
    case hal::Reason::no_permission:
    case hal::Reason::io_error:
    case hal::Reason::disk_full:
    case hal::Reason::bad_checksum:
    case hal::Reason::no_capacity:
      return true;
    default:
      return false;
  }
}

struct Try {
  std::optional<mapper::WrittenFile> file;
  std::optional<hal::Error> failure;
  [[nodiscard]] bool is_open() const { return !file && (!failure || may_pass(*failure)); }
};

void write_open_ones(const std::vector<OutputJob>& jobs, std::vector<Try>& tries, int& late_files) {
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    if (!tries[i].is_open()) continue;
    if (tries[i].failure && tries[i].failure->reason == hal::Reason::not_found) {
      std::error_code ignored;  // the job itself says what is wrong
      std::filesystem::create_directories(std::filesystem::path(jobs[i].path).parent_path(), ignored);
    }
    auto written = jobs[i].write();
    if (!written) {
      tries[i].failure = written.error();
      continue;
    }
    late_files += tries[i].failure ? 1 : 0;
    tries[i].file = std::move(written).value();
  }
}

/// False where a person has given up meanwhile.
bool wait_for_disk(const Patience& patience) {
  const auto given_up = [&] { return patience.is_given_up && patience.is_given_up(); };
  const hal::TimeNs until_ns = patience.clock->now() + kAgain_ns;
  while (!given_up() && patience.clock->now() < until_ns) {
    patience.clock->sleep_until(std::min(until_ns, patience.clock->now() + kLook_ns));
  }
  return !given_up();
}

}  // namespace

Outputs write_patiently(const std::vector<OutputJob>& jobs, const Patience& patience) {
  std::vector<Try> tries(jobs.size());
  const auto open_one = [&] {
    return std::find_if(tries.begin(), tries.end(), [](const Try& t) { return t.is_open(); });
  };
  Outputs outputs;
  write_open_ones(jobs, tries, outputs.late_files);
  if (patience.clock != nullptr && patience.seconds > 0.0 && open_one() != tries.end()) {
    if (patience.on_wait) patience.on_wait(*open_one()->failure);
    const hal::TimeNs end_ns = patience.clock->now() + static_cast<hal::TimeNs>(patience.seconds * 1e9);
    while (open_one() != tries.end() && patience.clock->now() < end_ns && wait_for_disk(patience)) {
      write_open_ones(jobs, tries, outputs.late_files);
    }
  }
  for (Try& t : tries) {
    if (!t.file) {
      outputs.failures.push_back(std::move(*t.failure));
      continue;
    }
    if (t.file->path.ends_with("/map.g3d")) outputs.map_file_bytes = t.file->bytes;
    outputs.files.push_back(std::move(*t.file));
  }
  return outputs;
}

}  // namespace g3d::nav
