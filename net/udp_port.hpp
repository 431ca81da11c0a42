// SPDX-License-Identifier: Apache-2.0
// The network as robots use it: one UDP socket of our own, which all leaves from and which others answer to, and one
// that listens to the fleet's multicast group together with every other robot of this machine. Who cannot be reached by
// multicast (another network, an access point that does not pass it on) is reached by its configured address.
//
//   own socket  :port        <── answers, and what peers send to the address they have configured
//   group       :group_port  <── what goes to everybody, one copy for every robot of a machine
//
// Radios go down and come back: the group is joined anew every second where it has to be. One thread; nothing allocates
// after open().
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hal/clock.hpp"
#include "hal/linux/multicast_group.hpp"
#include "hal/linux/udp_socket.hpp"
#include "net/datagram_port.hpp"

namespace g3d::net {

struct UdpPortOptions {
  std::string interface;                ///< that multicast goes through; empty: every one that is up
  std::string group = "239.255.71.77";  ///< of the addresses that stay within a site (RFC 2365)
  std::uint16_t port = 7177;            ///< where others answer to, and what their `peers` name
  std::uint16_t group_port = 7176;      ///< the same for the whole fleet
  std::vector<std::string> peers;  ///< "10.0.0.2:7177", numbers alone: everybody who is to hear us besides the group
  bool multicast = true;
  bool needs_port = false;  ///< `port` taken is an error; else another robot of this machine has it: any free one
  std::string address = "0.0.0.0";  ///< of ours that we listen at; this one is all of them
  int receive_buffer_bytes = 1 << 20;
};

struct UdpPortCounts {
  hal::UdpSocketCounts own;
  hal::UdpSocketCounts group;  ///< nothing is sent by it
  hal::MulticastCounts multicast;
  std::uint64_t nowhere = 0;  ///< what was to go to everybody while no interface was up and no peer is configured
};

class UdpPort final : public DatagramPort {
 public:
  static constexpr std::size_t kMostPeers = 64;
  static constexpr hal::TimeNs kRefresh_ns = 1000 * hal::kMillisecond_ns;

  /// Errors: bad_usage (an option cannot be), no_capacity (the port is taken), no_permission, not_found, io_error. That
  /// no interface is up is none: one may come.
  [[nodiscard]] static hal::Result<std::unique_ptr<UdpPort>> open(const UdpPortOptions& options);

  bool send(Address to, mapper::ByteSpan datagram) override;
  [[nodiscard]] std::optional<Received> receive() override;
  /// Until something has come, at most so long. Whether something has.
  bool wait(hal::TimeNs at_most_ns);
  /// Joins the group where an interface has come; receive() does it every second.
  void refresh();

  /// Where others answer to: options().port, unless that was taken.
  [[nodiscard]] std::uint16_t port() const { return own_->bound().port; }
  /// Through how many interfaces the group is reached now.
  [[nodiscard]] std::size_t interfaces() const { return membership_ ? membership_->joined().size() : 0; }
  [[nodiscard]] UdpPortCounts counts() const;

  [[nodiscard]] static constexpr Address address_of(std::uint32_t ipv4, std::uint16_t port) {
    return kAddressMark | std::uint64_t{ipv4} << 16 | port;
  }
  [[nodiscard]] static constexpr hal::Ipv4Endpoint endpoint_of(Address address) {
    return {static_cast<std::uint32_t>(address >> 16), static_cast<std::uint16_t>(address)};
  }
  /// "10.0.0.2:4711", or "everybody".
  [[nodiscard]] static std::string text_of(Address address);

 private:
  /// So that no endpoint is kEverybody.
  static constexpr Address kAddressMark = Address{1} << 48;

  UdpPort(const UdpPortOptions& options, std::unique_ptr<hal::UdpSocket> own, std::unique_ptr<hal::UdpSocket> group);
  bool send_to_everybody(mapper::ByteSpan datagram);
  void refresh_if_due();

  const std::unique_ptr<hal::UdpSocket> own_;
  const std::unique_ptr<hal::UdpSocket> group_;      ///< or none
  std::unique_ptr<hal::MulticastGroup> membership_;  ///< along with it
  std::vector<hal::Ipv4Endpoint> peers_;
  bool group_turn_ = false;
  const hal::RealClock clock_;
  hal::TimeNs refreshed_ns_ = 0;
  std::uint64_t nowhere_ = 0;
};

}  // namespace g3d::net
