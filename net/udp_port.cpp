// SPDX-License-Identifier: Apache-2.0
#include "net/udp_port.hpp"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <ctime>
#include <utility>

#include "net/datagram_seal.hpp"

namespace g3d::net {
namespace {

hal::Error bad_option(const std::string& text) { return {hal::Reason::bad_usage, "radio: " + text}; }

hal::Result<std::vector<hal::Ipv4Endpoint>> read_peers(const std::vector<std::string>& texts) {
  if (texts.size() > UdpPort::kMostPeers) {
    return bad_option(fmt::format("{} peers, {} are the most; leave those to the multicast group that it reaches",
                                  texts.size(), UdpPort::kMostPeers));
  }
  std::vector<hal::Ipv4Endpoint> peers;
  for (const std::string& text : texts) {
    const auto peer = hal::parse_ipv4_endpoint(text);
    if (!peer || peer->ipv4 == 0 || hal::is_multicast(peer->ipv4)) {
      return bad_option(fmt::format("peer '{}' is no address and port; write it in numbers, as 10.0.0.2:7177", text));
    }
    if (std::find(peers.begin(), peers.end(), *peer) == peers.end()) peers.push_back(*peer);
  }
  return peers;
}

hal::Result<std::unique_ptr<hal::UdpSocket>> open_own(const UdpPortOptions& options, std::uint32_t ipv4) {
  hal::UdpSocketOptions own;
  own.bind = {ipv4, options.port};
  own.most_datagram_bytes = kMostDatagram_bytes;
  own.receive_buffer_bytes = options.receive_buffer_bytes;
  auto socket = hal::UdpSocket::open(own);
  if (socket || options.needs_port || socket.error().reason != hal::Reason::no_capacity) return socket;
  own.bind.port = 0;
  return hal::UdpSocket::open(own);
}

}  // namespace

hal::Result<std::unique_ptr<UdpPort>> UdpPort::open(const UdpPortOptions& options) {
  const auto address = hal::parse_ipv4(options.address);
  if (!address || hal::is_multicast(*address)) {
    return bad_option(fmt::format("address '{}' is none of ours; write it in numbers, as 10.0.0.2, or 0.0.0.0 for all",
                                  options.address));
  }
  const auto group_ipv4 = hal::parse_ipv4(options.group);
  if (options.multicast && (!group_ipv4 || !hal::is_multicast(*group_ipv4) || options.group_port == 0)) {
    return bad_option(
        fmt::format("group '{}:{}' is no multicast address and port; write it as 239.255.71.77, port 7176",
                    options.group, options.group_port));
  }
  const auto peers = read_peers(options.peers);
  if (!peers) return peers.error();
  auto own = open_own(options, *address);
  if (!own) return own.error();
  std::unique_ptr<hal::UdpSocket> group;
  if (options.multicast) {
    hal::UdpSocketOptions shared;
    shared.bind = {*group_ipv4, options.group_port};
    shared.shares_port = true;
    shared.most_datagram_bytes = kMostDatagram_bytes;
    shared.receive_buffer_bytes = options.receive_buffer_bytes;
    auto opened = hal::UdpSocket::open(shared);
    if (!opened) return opened.error();
    group = std::move(opened).value();
  }
  std::unique_ptr<UdpPort> port(new UdpPort(options, std::move(own).value(), std::move(group)));
  port->peers_ = peers.value();
  port->refresh();
  return port;
}

UdpPort::UdpPort(const UdpPortOptions& options, std::unique_ptr<hal::UdpSocket> own,
                 std::unique_ptr<hal::UdpSocket> group)
    : own_(std::move(own)), group_(std::move(group)) {
  if (group_) {
    membership_ = std::make_unique<hal::MulticastGroup>(group_->fd(), group_->bound().ipv4, options.interface);
  }
}

void UdpPort::refresh() {
  refreshed_ns_ = clock_.now();
  if (membership_) membership_->refresh();
}

void UdpPort::refresh_if_due() {
  if (clock_.now() - refreshed_ns_ >= kRefresh_ns) refresh();
}

bool UdpPort::send(Address to, mapper::ByteSpan datagram) {
  return to == kEverybody ? send_to_everybody(datagram) : own_->send(endpoint_of(to), datagram);
}

bool UdpPort::send_to_everybody(mapper::ByteSpan datagram) {
  bool is_sent = false;
  if (membership_) {
    for (hal::Leaving leaving : membership_->joined()) {
      // Whoever answers must find us: where we listen at one address alone, there.
      if (own_->bound().ipv4 != 0) leaving.source_ipv4 = own_->bound().ipv4;
      is_sent |= own_->send(group_->bound(), datagram, leaving);
    }
  }
  for (const hal::Ipv4Endpoint& peer : peers_) is_sent |= own_->send(peer, datagram);
  if (peers_.empty() && interfaces() == 0) ++nowhere_;
  return is_sent;
}

std::optional<DatagramPort::Received> UdpPort::receive() {
  // The sockets take turns, a batch each, so that a flood at one does not drown the other.
  for (int tries = 0; tries < (group_ ? 2 : 1); ++tries) {
    hal::UdpSocket& socket = group_turn_ ? *group_ : *own_;
    if (socket.left_in_batch() == 0) refresh_if_due();
    const auto received = socket.receive();
    if (group_ && socket.left_in_batch() == 0) group_turn_ = !group_turn_;
    if (received) return Received{address_of(received->from.ipv4, received->from.port), received->datagram};
  }
  return std::nullopt;
}

bool UdpPort::wait(hal::TimeNs at_most_ns) {
  if (own_->left_in_batch() > 0 || (group_ && group_->left_in_batch() > 0)) return true;
  pollfd waits[2] = {{own_->fd(), POLLIN, 0}, {group_ ? group_->fd() : -1, POLLIN, 0}};  // -1 is passed over
  const hal::TimeNs bounded_ns = std::max<hal::TimeNs>(at_most_ns, 0);
  const timespec patience{static_cast<time_t>(bounded_ns / 1'000'000'000),
                          static_cast<long>(bounded_ns % 1'000'000'000)};
  return ::ppoll(waits, 2, &patience, nullptr) > 0;
}

UdpPortCounts UdpPort::counts() const {
  UdpPortCounts counts;
  counts.own = own_->counts();
  if (group_) counts.group = group_->counts();
  if (membership_) counts.multicast = membership_->counts();
  counts.nowhere = nowhere_;
  return counts;
}

std::string UdpPort::text_of(Address address) {
  return address == kEverybody ? "everybody" : hal::to_string(endpoint_of(address));
}

}  // namespace g3d::net
