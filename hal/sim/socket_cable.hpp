// SPDX-License-Identifier: Apache-2.0
// A simulated base's cable as a byte stream: at its other end stands the serial adapter of an emulated machine (QEMU's
// `-chardev socket`), on whichever side of the connection. It comes and goes as it likes. Like a real line it holds
// back little: what was said while nobody listened is gone, so that a replugged host hears no old packets.
#pragma once

#include "hal/clock.hpp"
#include "hal/linux/stream_link.hpp"
#include "hal/sim/base_cable.hpp"

namespace g3d::hal {

class SocketCable final : public BaseCable {
 public:
  /// `clock` outlives this.
  SocketCable(StreamLink link, const Clock& clock) : link_(std::move(link)), clock_(clock) {}

  [[nodiscard]] std::string path() const override { return is_out_ ? std::string{} : to_string(link_.place()); }
  void pump(ByteLine& device) override;
  [[nodiscard]] std::uint64_t lost_bytes() const override { return lost_bytes_; }
  void pull_out() override;
  [[nodiscard]] Result<void> plug_in() override;
  [[nodiscard]] std::uint64_t connections() const override { return link_.connections(); }
  [[nodiscard]] bool is_connected() const override { return link_.fd() >= 0; }

 private:
  void to_device(int fd, ByteLine& device);
  void to_host(int fd, ByteLine& device);

  StreamLink link_;
  const Clock& clock_;
  bool is_out_ = false;
  std::uint64_t seen_connections_ = 0;
  std::uint64_t lost_bytes_ = 0;
};

}  // namespace g3d::hal
