// SPDX-License-Identifier: Apache-2.0
// A serial port as a ByteLine: raw termios, 115200 8N1, no flow control, opened without waiting. An unplugged port is
// seen at the next read or write and says `lost`; while lost, read() looks for the port again every tenth of a second,
// under whatever name it has then. One thread uses it.
#pragma once

#include <functional>
#include <string>

#include "hal/byte_line.hpp"
#include "hal/clock.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

enum class LowLatency { unknown, set, refused };
[[nodiscard]] const char* to_string(LowLatency low_latency);

class SerialPort final : public ByteLine {
 public:
  struct Options {
    /// Where the port is now; asked again after a loss.
    std::function<Result<std::string>()> find;
    /// Called with every new file descriptor, from the constructor's or the reading thread: for the LineGuard.
    std::function<void(int fd)> on_open;
    TimeNs retry_ns = 100'000'000;
  };

  /// Does not open: call open(), or read() until the line is up. `clock` must outlive the port.
  SerialPort(Options options, const Clock& clock);
  ~SerialPort() override;
  SerialPort(const SerialPort&) = delete;
  SerialPort& operator=(const SerialPort&) = delete;

  /// Opens now. Errors: those of `find`, not_found, no_permission, io_error, unsupported (no serial port),
  /// no_capacity (another process holds it).
  [[nodiscard]] Result<void> open();
  void close();

  [[nodiscard]] std::size_t read(std::span<std::uint8_t> into) override;
  [[nodiscard]] bool write(std::span<const std::uint8_t> bytes) override;
  [[nodiscard]] LineState state() const override { return fd_ >= 0 ? LineState::up : LineState::lost; }

  [[nodiscard]] int fd() const { return fd_; }
  /// Whether the adapter hands over bytes at once (ASYNC_LOW_LATENCY). Refused: up to 16 ms of delay and, with some
  /// adapters, torn packets; set latency_timer to 1 by a udev rule.
  [[nodiscard]] LowLatency low_latency() const { return low_latency_; }
  [[nodiscard]] const std::string& path() const { return path_; }
  /// How often the port was opened.
  [[nodiscard]] int opened() const { return opened_; }
  [[nodiscard]] std::uint64_t refused_writes() const { return refused_writes_; }

 private:
  [[nodiscard]] Result<void> configure(int fd);

  const Options options_;
  const Clock& clock_;
  int fd_ = -1;
  std::string path_;
  LowLatency low_latency_ = LowLatency::unknown;
  int opened_ = 0;
  std::uint64_t refused_writes_ = 0;
  bool may_retry_ = true;  ///< not after close()
  TimeNs next_try_ns_ = 0;
};

/// Puts a terminal into the state described above; what other openers of the same line need too.
[[nodiscard]] bool set_raw_115200(int fd);

}  // namespace g3d::hal
