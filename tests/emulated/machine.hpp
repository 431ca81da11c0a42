// SPDX-License-Identifier: Apache-2.0
// A whole robot's computer, emulated: QEMU's 64-bit Arm board with U-Boot, which starts what lies on a disk image. From
// outside it has a console, a power switch, a USB socket with the base in it, a network cable, and an e-stop line.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/run_program.hpp"
#include "tests/support/temp_folder.hpp"

namespace g3d::test {

struct MachineOptions {
  std::string disk;                 ///< image; it is written to
  std::string base_socket;          ///< of a simulated base: QEMU listens there; empty: nothing is plugged in
  std::string camera_socket;        ///< of a simulated camera: QEMU dials it; empty: none
  std::vector<std::string> netdev;  ///< more of QEMU's arguments, for the network
  int number = 1;                   ///< of several machines: their network cards differ
};

class Machine {
 public:
  /// What an emulated machine needs and this one has not, for people; empty: nothing.
  [[nodiscard]] static std::string what_is_missing();

  explicit Machine(MachineOptions options);
  ~Machine();
  Machine(const Machine&) = delete;
  Machine& operator=(const Machine&) = delete;

  void power_on();
  /// Everything the machine had in its memory is gone.
  void cut_power();
  [[nodiscard]] bool is_on();

  /// What the console has shown since `from`; power_on() goes on behind what was.
  [[nodiscard]] std::string console(std::size_t from = 0) const;
  [[nodiscard]] std::size_t console_size() const { return console().size(); }
  /// Waits until the console shows `text` behind `from`: the line that it is in. Nothing if it never does.
  [[nodiscard]] std::optional<std::string> await(const std::string& text, std::chrono::seconds limit,
                                                 std::size_t from = 0) const;
  /// A line as if somebody typed it.
  void type(const std::string& line);

  /// The base is pulled out of its USB socket, and put in again. False: QEMU refused.
  [[nodiscard]] bool unplug_base();
  [[nodiscard]] bool plug_base();
  /// Line 3 of the GPIO chip goes high for a tenth of a second: the board's power key, which nothing else uses.
  [[nodiscard]] bool pulse_gpio();

 private:
  [[nodiscard]] std::string ask_qemu(const std::string& command);

  MachineOptions options_;
  TempFolder folder_;
  std::unique_ptr<Program> qemu_;
  int console_fd_ = -1;
  std::thread reader_;
};

/// The seconds since the kernel began, in a line of the first process: "[    4.321] ...".
[[nodiscard]] double guest_time_s(const std::string& line);

}  // namespace g3d::test
