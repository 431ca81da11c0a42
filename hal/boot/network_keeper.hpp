// SPDX-License-Identifier: Apache-2.0
// Keeps one network card on the network: a fixed address or a link-local one that is asked for and defended, and
// answers to NAME.local. Never waits. One thread.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/boot/init_config.hpp"
#include "hal/boot/link_local.hpp"
#include "hal/boot/mdns_answer.hpp"
#include "hal/linux/udp_socket.hpp"
#include "hal/messages.hpp"
#include "hal/result.hpp"

namespace g3d::hal::boot {

struct NetworkKeeperOptions {
  std::string name;  ///< NAME.local
  std::string card;
  std::optional<FixedAddress> address;  ///< none: link-local
  std::optional<std::uint32_t> gateway;
};

class NetworkKeeper {
 public:
  /// Switches the card on. Errors: not_found, no_permission, io_error.
  [[nodiscard]] static Result<std::unique_ptr<NetworkKeeper>> start(const NetworkKeeperOptions& options, TimeNs now_ns);
  ~NetworkKeeper();
  NetworkKeeper(const NetworkKeeper&) = delete;
  NetworkKeeper& operator=(const NetworkKeeper&) = delete;

  /// Whatever is due or has come. Call often, at the latest when one of fds() can be read or at next_ns().
  void on_time(TimeNs now_ns);
  [[nodiscard]] std::vector<int> fds() const;
  [[nodiscard]] TimeNs next_ns() const;
  /// Host byte order; nothing while it is still asked for.
  [[nodiscard]] std::optional<std::uint32_t> address() const { return address_; }
  [[nodiscard]] std::uint64_t mdns_answers() const { return mdns_answers_; }
  /// What went wrong since the last call.
  [[nodiscard]] std::vector<std::string> take_troubles();

 private:
  NetworkKeeper(const NetworkKeeperOptions& options, int index, const MacAddress& mac)
      : options_(options), index_(index), mac_(mac) {}
  void take_address(std::uint32_t ipv4, int prefix_bits);
  void drop_address();
  void ask_with_arp(TimeNs now_ns);
  void send_arp(const Arp& arp);
  void open_mdns();
  void answer_names();

  const NetworkKeeperOptions options_;
  const int index_;
  const MacAddress mac_;
  std::optional<LinkLocal> link_local_;
  int arp_fd_ = -1;
  std::unique_ptr<UdpSocket> mdns_;
  std::optional<std::uint32_t> address_;
  std::uint64_t mdns_answers_ = 0;
  std::vector<std::string> troubles_;
};

}  // namespace g3d::hal::boot
