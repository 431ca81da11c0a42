// SPDX-License-Identifier: Apache-2.0
#include "net/key_file_watch.hpp"

#include <sys/stat.h>

#include "net/fleet_key_file.hpp"

namespace g3d::net {

KeyFileWatch::Stamp KeyFileWatch::stamp() const {
  struct stat file {};
  if (::stat(path_.c_str(), &file) != 0) return {};
  // The time of the change, not of the content: it tells of permissions as well, and nobody sets it.
  return {file.st_dev, file.st_ino, file.st_size,
          std::int64_t{file.st_ctim.tv_sec} * 1'000'000'000 + std::int64_t{file.st_ctim.tv_nsec}};
}

std::optional<hal::Result<FleetKey>> KeyFileWatch::look(hal::TimeNs now_ns) {
  if (looked_ns_ && now_ns - *looked_ns_ < period_ns_) return std::nullopt;
  looked_ns_ = now_ns;
  const Stamp now = stamp();  // before it is read: what changes meanwhile is seen the next time
  if (seen_ == now) return std::nullopt;
  seen_ = now;
  hal::Result<FleetKey> read = read_fleet_key(path_);
  if (!read) ++rejected_;
  return read;
}

}  // namespace g3d::net
