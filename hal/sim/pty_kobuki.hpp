// SPDX-License-Identifier: Apache-2.0
// A pseudo-terminal that stands for the cable of a simulated base: programs open its path like a serial port. Whoever
// runs the base moves the bytes by calling pump() every millisecond or two.
#pragma once

#include <cstdint>
#include <string>

#include "hal/byte_line.hpp"
#include "hal/result.hpp"
#include "hal/sim/base_cable.hpp"

namespace g3d::hal {

class PtyKobuki final : public BaseCable {
 public:
  /// `link`, if not empty: a symbolic link that always points to the terminal, also after plug_in().
  [[nodiscard]] static Result<PtyKobuki> open(const std::string& link = {});
  ~PtyKobuki() override;
  PtyKobuki(PtyKobuki&& other) noexcept;
  PtyKobuki& operator=(PtyKobuki&&) = delete;

  /// /dev/pts/N, empty while unplugged.
  [[nodiscard]] std::string path() const override { return path_; }
  /// What the host wrote goes to the device, what the device says to the host. Never blocks; what does not fit into
  /// the terminal's buffer, because the host does not read, is lost and counted.
  void pump(ByteLine& device) override;
  [[nodiscard]] std::uint64_t lost_bytes() const override { return lost_bytes_; }

  /// The host sees its port vanish.
  void pull_out() override;
  /// Another terminal, and another path but for the link.
  [[nodiscard]] Result<void> plug_in() override;

 private:
  explicit PtyKobuki(std::string link) : link_(std::move(link)) {}

  std::string link_;
  std::string path_;
  int master_ = -1;
  int keep_ = -1;  ///< our own hold on the host's end: without one, a host that closes it would end the terminal
  std::uint64_t lost_bytes_ = 0;
};

}  // namespace g3d::hal
