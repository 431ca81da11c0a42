// SPDX-License-Identifier: Apache-2.0
// The receiving end of systemd's notification protocol: a datagram socket in the file system that only root may write
// to. One thread; never waits.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "hal/boot/robot_health.hpp"
#include "hal/result.hpp"

namespace g3d::hal::boot {

class NotifySocket {
 public:
  /// One that is left over is replaced. Errors: too_large (the path), io_error.
  [[nodiscard]] static Result<std::unique_ptr<NotifySocket>> open(const std::string& path);
  ~NotifySocket();
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;

  [[nodiscard]] std::optional<Notice> receive();
  [[nodiscard]] int fd() const { return fd_; }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  NotifySocket(std::string path, int fd) : path_(std::move(path)), fd_(fd) {}
  std::string path_;
  int fd_;
};

}  // namespace g3d::hal::boot
