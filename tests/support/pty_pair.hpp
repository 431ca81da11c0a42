// SPDX-License-Identifier: Apache-2.0
// A pseudo-terminal whose far end the test plays: what it writes arrives at the port, what the port writes it reads.
// Closing it is what unplugging is to a serial port.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace g3d::test {

class PtyPair {
 public:
  PtyPair();
  ~PtyPair();
  PtyPair(const PtyPair&) = delete;
  PtyPair& operator=(const PtyPair&) = delete;

  /// Of the port's end.
  [[nodiscard]] const std::string& path() const { return path_; }
  /// The far end's descriptor, non-blocking.
  [[nodiscard]] int fd() const { return fd_; }
  void write(std::span<const std::uint8_t> bytes) const;
  /// Up to `count` bytes, as many as come while none is missing for longer than `timeout_ms`.
  [[nodiscard]] std::vector<std::uint8_t> read_all(std::size_t count, int timeout_ms = 200) const;

 private:
  int fd_ = -1;
  std::string path_;
};

}  // namespace g3d::test
