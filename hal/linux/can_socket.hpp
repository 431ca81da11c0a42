// SPDX-License-Identifier: Apache-2.0
// A raw socket at a CAN interface as a CanPort that never waits. Reading and writing belong to one thread; what takes
// longer (opening, restarting the controller) is another one's (can_keeper.hpp), which sees here what is needed and
// hands over a new socket.
#pragma once

#include <atomic>
#include <string>

#include "hal/can/can_frame.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

/// Opens and binds: all frames, error frames too, none of our own. Errors: not_found (no such interface),
/// unsupported (no CAN in this kernel), no_permission, io_error.
[[nodiscard]] Result<int> open_can_socket(const std::string& interface);

class CanSocket final : public can::CanPort {
 public:
  /// Owns `fd`, a socket that gives whole `struct can_frame`s; -1: has none yet.
  explicit CanSocket(int fd = -1);
  ~CanSocket() override;
  CanSocket(const CanSocket&) = delete;
  CanSocket& operator=(const CanSocket&) = delete;

  [[nodiscard]] bool read(can::CanFrame& frame) override;
  bool write(const can::CanFrame& frame) override;
  [[nodiscard]] const can::CanCounts& counts() const override { return counts_; }

  // Any other thread
  /// It has none, and none is waiting: the interface is gone.
  [[nodiscard]] bool needs_socket() const {
    return !has_socket_.load(std::memory_order_acquire) && offered_fd_.load(std::memory_order_acquire) < 0;
  }
  /// The controller has given up and nothing was heard since.
  [[nodiscard]] bool bus_is_off() const { return bus_is_off_.load(std::memory_order_acquire); }
  [[nodiscard]] bool link_is_down() const { return link_is_down_.load(std::memory_order_acquire); }
  /// Somebody has brought the link up; that it went down is told but once.
  void note_link_up() { link_is_down_.store(false, std::memory_order_release); }
  /// Owns `fd` from now on; used from the next read on. One that waits already is closed.
  void hand_over(int fd);

 private:
  void take_offered();
  void lose_socket();
  void note_error_frame(std::uint32_t classes);
  void note_down();
  void note_overflow(std::uint32_t total);

  int fd_;
  std::atomic<bool> has_socket_;
  std::atomic<int> offered_fd_{-1};
  std::atomic<bool> bus_is_off_{false}, link_is_down_{false};
  std::uint32_t overflow_total_ = 0;  ///< as the kernel counts, modulo 2^32
  can::CanCounts counts_;
};

}  // namespace g3d::hal
