// SPDX-License-Identifier: Apache-2.0
// What the processes of a robot say, in a bounded ring of files: log/0.log to log/7.log, the oldest of which is begun
// anew when the newest is full. Survives power cuts as far as the disk had it; never grows beyond its bound. One
// thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "hal/result.hpp"

namespace g3d::hal::boot {

class LogRing {
 public:
  struct Bounds {
    int files = 8;
    std::size_t file_bytes = 1U << 20;
  };
  explicit LogRing(Bounds bounds) : bounds_(bounds) {}
  ~LogRing();
  LogRing(const LogRing&) = delete;
  LogRing& operator=(const LogRing&) = delete;

  /// Makes the folder and goes on in the newest file of it. Errors: those of the folder.
  [[nodiscard]] Result<void> open(const std::string& folder);
  /// Lines after this are lost: a file system cannot be left while a file of it is open.
  void close();
  /// A line without its end. Cut at 1000 bytes; thrown away and counted where the disk does not take it.
  void write(std::string_view line);
  /// Bytes of the last lines, for a console.
  [[nodiscard]] std::string tail(std::size_t most_bytes) const;
  [[nodiscard]] std::uint64_t lost_lines() const { return lost_lines_; }

 private:
  [[nodiscard]] std::string path(int number) const;
  [[nodiscard]] bool begin(int number, bool anew);

  Bounds bounds_;
  std::string folder_;
  int fd_ = -1;
  int number_ = 0;
  std::size_t written_bytes_ = 0;
  std::uint64_t lost_lines_ = 0;
};

}  // namespace g3d::hal::boot
