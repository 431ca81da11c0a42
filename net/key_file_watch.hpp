// SPDX-License-Identifier: Apache-2.0
// Notices when somebody has changed the file of the fleet's key, as `g3dmap key --rotate` does, so that a robot need
// not be started anew. A file that is gone or bad changes nothing: the keys so far stay, and it is told once for each
// time the file has changed. One thread; looking asks the file system.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>

#include "hal/messages.hpp"
#include "hal/result.hpp"
#include "net/fleet_key.hpp"

namespace g3d::net {

class KeyFileWatch {
 public:
  explicit KeyFileWatch(std::string path, hal::TimeNs period_ns = 1'000 * hal::kMillisecond_ns)
      : path_(std::move(path)), period_ns_(period_ns) {}

  /// The keys, or why not, if the file is another one than at the last look; nothing if it is the same, or was looked
  /// at a moment ago. The first look finds it changed.
  [[nodiscard]] std::optional<hal::Result<FleetKey>> look(hal::TimeNs now_ns);
  [[nodiscard]] std::uint64_t rejected() const { return rejected_; }

 private:
  /// What a file that was written anew has otherwise. All zero: there is none.
  struct Stamp {
    dev_t device = 0;
    ino_t inode = 0;
    off_t bytes = 0;
    std::int64_t changed_ns = 0;
    bool operator==(const Stamp&) const = default;
  };
  [[nodiscard]] Stamp stamp() const;

  const std::string path_;
  const hal::TimeNs period_ns_;
  std::optional<Stamp> seen_;
  std::optional<hal::TimeNs> looked_ns_;
  std::uint64_t rejected_ = 0;
};

}  // namespace g3d::net
