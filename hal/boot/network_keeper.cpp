// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/network_keeper.hpp"

#include <arpa/inet.h>
#include <errno.h>
#include <linux/if_packet.h>
#include <net/ethernet.h>
#include <netinet/in.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <utility>

#include "hal/boot/network_card.hpp"
#include "hal/image/atomic_file.hpp"

namespace g3d::hal::boot {
namespace {

constexpr int kMostPackets = 64;  // at a time
constexpr int kLinkLocalBits = 16;
constexpr std::size_t kMostMdns_bytes = 1500;

sockaddr_ll arp_place(int index) {
  sockaddr_ll place{};
  place.sll_family = AF_PACKET;
  place.sll_protocol = htons(ETH_P_ARP);
  place.sll_ifindex = index;
  place.sll_halen = 6;
  ::memset(place.sll_addr, 0xFF, 6);
  return place;
}

}  // namespace

Result<std::unique_ptr<NetworkKeeper>> NetworkKeeper::start(const NetworkKeeperOptions& options, TimeNs now_ns) {
  if (const auto on = switch_on(options.card); !on) return on.error();
  const auto mac = mac_of(options.card);
  if (!mac) return system_error(options.card, "is no Ethernet card", ENODEV);
  std::unique_ptr<NetworkKeeper> keeper(new NetworkKeeper(options, index_of(options.card), *mac));
  if (options.address) {
    keeper->take_address(options.address->ipv4, options.address->prefix_bits);
    return keeper;
  }
  keeper->arp_fd_ = ::socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, htons(ETH_P_ARP));
  const sockaddr_ll place = arp_place(keeper->index_);
  if (keeper->arp_fd_ < 0 || ::bind(keeper->arp_fd_, reinterpret_cast<const sockaddr*>(&place), sizeof place) != 0) {
    return system_error(options.card, "cannot be asked with ARP", errno);
  }
  keeper->link_local_.emplace(*mac, now_ns);
  return keeper;
}

NetworkKeeper::~NetworkKeeper() {
  if (arp_fd_ >= 0) ::close(arp_fd_);
}

void NetworkKeeper::take_address(std::uint32_t ipv4, int prefix_bits) {
  if (const auto set = set_address(options_.card, ipv4, prefix_bits); !set) {
    troubles_.push_back(set.error().text);
    return;
  }
  address_ = ipv4;
  if (options_.gateway) {
    if (const auto set = set_gateway(*options_.gateway); !set) troubles_.push_back(set.error().text);
  }
  open_mdns();
}

void NetworkKeeper::drop_address() {
  mdns_.reset();
  address_.reset();
  if (const auto set = set_address(options_.card, 0, kLinkLocalBits); !set) troubles_.push_back(set.error().text);
}

void NetworkKeeper::open_mdns() {
  auto socket = UdpSocket::open({{0, kMdnsPort}, true, 255, kMostMdns_bytes, 1 << 16});
  if (!socket) {
    troubles_.push_back(socket.error().text);
    return;
  }
  mdns_ = std::move(socket).value();
  ip_mreqn group{};
  group.imr_multiaddr.s_addr = htonl(kMdnsGroup_ipv4);
  group.imr_ifindex = index_;
  if (::setsockopt(mdns_->fd(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group) != 0) {
    troubles_.push_back(system_error(options_.card, "cannot join the group of multicast DNS", errno).text);
  }
  std::array<std::uint8_t, 256> out{};
  const std::size_t size = announce_mdns({options_.name, *address_}, out);
  (void)mdns_->send({kMdnsGroup_ipv4, kMdnsPort}, {out.data(), size}, Leaving{index_, *address_});
}

void NetworkKeeper::answer_names() {
  for (int i = 0; mdns_ != nullptr && i < kMostPackets; ++i) {
    const auto question = mdns_->receive();
    if (!question) return;
    std::array<std::uint8_t, 256> out{};
    const MdnsAnswer answer =
        answer_mdns(question->datagram, question->from.port == kMdnsPort, {options_.name, *address_}, out);
    if (answer.size_bytes == 0) continue;
    const Ipv4Endpoint to = answer.goes_to_asker ? question->from : Ipv4Endpoint{kMdnsGroup_ipv4, kMdnsPort};
    if (mdns_->send(to, {out.data(), answer.size_bytes}, Leaving{index_, *address_})) ++mdns_answers_;
  }
}

void NetworkKeeper::send_arp(const Arp& arp) {
  const ArpPacket packet = encode_arp(arp);
  const sockaddr_ll place = arp_place(index_);
  // What is lost is said again, or was a courtesy.
  (void)::sendto(arp_fd_, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&place), sizeof place);
}

void NetworkKeeper::ask_with_arp(TimeNs now_ns) {
  std::array<std::uint8_t, 64> bytes{};
  for (int i = 0; i < kMostPackets; ++i) {
    const ssize_t size = ::recv(arp_fd_, bytes.data(), bytes.size(), 0);
    if (size < 0) break;
    const auto heard = decode_arp({bytes.data(), static_cast<std::size_t>(size)});
    if (!heard) continue;
    if (const auto defence = link_local_->on_arp(*heard, now_ns)) send_arp(*defence);
  }
  if (const auto word = link_local_->on_time(now_ns)) send_arp(*word);
  const auto granted = link_local_->address();
  if (granted == address_) return;
  if (address_) drop_address();
  if (granted) take_address(*granted, kLinkLocalBits);
}

void NetworkKeeper::on_time(TimeNs now_ns) {
  if (link_local_) ask_with_arp(now_ns);
  answer_names();
}

std::vector<int> NetworkKeeper::fds() const {
  std::vector<int> fds;
  if (arp_fd_ >= 0) fds.push_back(arp_fd_);
  if (mdns_ != nullptr) fds.push_back(mdns_->fd());
  return fds;
}

TimeNs NetworkKeeper::next_ns() const { return link_local_ ? link_local_->next_ns() : INT64_MAX; }

std::vector<std::string> NetworkKeeper::take_troubles() { return std::exchange(troubles_, {}); }

}  // namespace g3d::hal::boot
