// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/link_local.hpp"

#include <algorithm>

namespace g3d::hal::boot {
namespace {

constexpr std::uint32_t kFirstLinkLocal = 0xA9FE0100;  // 169.254.1.0: the first and last 256 are reserved
constexpr std::uint32_t kLinkLocalCount = 0xFE00;
constexpr std::array<std::uint8_t, 6> kEthernetIpv4 = {0, 1, 8, 0, 6, 4};

void put_ipv4(ArpPacket& packet, std::size_t at, std::uint32_t ipv4) {
  for (std::size_t i = 0; i < 4; ++i) packet[at + i] = static_cast<std::uint8_t>(ipv4 >> (24 - 8 * i));
}

std::uint32_t get_ipv4(std::span<const std::uint8_t> bytes, std::size_t at) {
  std::uint32_t ipv4 = 0;
  for (std::size_t i = 0; i < 4; ++i) ipv4 = ipv4 << 8U | bytes[at + i];
  return ipv4;
}

}  // namespace

ArpPacket encode_arp(const Arp& arp) {
  ArpPacket packet{};
  std::copy(kEthernetIpv4.begin(), kEthernetIpv4.end(), packet.begin());
  packet[7] = arp.is_request ? 1 : 2;
  std::copy(arp.sender_mac.begin(), arp.sender_mac.end(), packet.begin() + 8);
  put_ipv4(packet, 14, arp.sender_ipv4);
  put_ipv4(packet, 24, arp.target_ipv4);
  return packet;
}

std::optional<Arp> decode_arp(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < std::tuple_size_v<ArpPacket>) return std::nullopt;
  if (!std::equal(kEthernetIpv4.begin(), kEthernetIpv4.end(), bytes.begin())) return std::nullopt;
  if (bytes[6] != 0 || (bytes[7] != 1 && bytes[7] != 2)) return std::nullopt;
  Arp arp;
  arp.is_request = bytes[7] == 1;
  std::copy_n(bytes.begin() + 8, 6, arp.sender_mac.begin());
  arp.sender_ipv4 = get_ipv4(bytes, 14);
  arp.target_ipv4 = get_ipv4(bytes, 24);
  return arp;
}

LinkLocal::LinkLocal(const MacAddress& mac, TimeNs now_ns) : mac_(mac), random_(0x9E3779B97F4A7C15U) {
  // The same card begins with the same address at every start.
  for (const std::uint8_t byte : mac) random_ = (random_ ^ byte) * 0x100000001B3U;
  choose(now_ns);
}

std::uint64_t LinkLocal::draw() {
  // splitmix64
  random_ += 0x9E3779B97F4A7C15U;
  std::uint64_t z = random_;
  z = (z ^ z >> 30U) * 0xBF58476D1CE4E5B9U;
  z = (z ^ z >> 27U) * 0x94D049BB133111EBU;
  return z ^ z >> 31U;
}

void LinkLocal::choose(TimeNs now_ns) {
  ipv4_ = kFirstLinkLocal + static_cast<std::uint32_t>(draw() % kLinkLocalCount);
  sent_ = 0;
  conflict_ns_.reset();
  // Machines that are switched on together do not all ask at once.
  next_ns_ = now_ns + static_cast<TimeNs>(draw() % static_cast<std::uint64_t>(kProbePeriod_ns));
  if (conflicts_ > kMostConflicts) next_ns_ = now_ns + kRateLimit_ns;
}

std::optional<std::uint32_t> LinkLocal::address() const {
  return sent_ > kProbes ? std::optional(ipv4_) : std::nullopt;
}

std::optional<Arp> LinkLocal::on_time(TimeNs now_ns) {
  if (now_ns < next_ns_ || sent_ >= kProbes + kAnnouncements) return std::nullopt;
  ++sent_;
  if (sent_ < kProbes) {
    next_ns_ = now_ns + kProbePeriod_ns + static_cast<TimeNs>(draw() % static_cast<std::uint64_t>(kProbePeriod_ns));
  } else if (sent_ < kProbes + kAnnouncements) {
    next_ns_ = now_ns + kAnnounceWait_ns;
  } else {
    next_ns_ = INT64_MAX;
  }
  return Arp{true, mac_, sent_ <= kProbes ? 0 : ipv4_, ipv4_};
}

std::optional<Arp> LinkLocal::on_arp(const Arp& heard, TimeNs now_ns) {
  if (heard.sender_mac == mac_) return std::nullopt;
  const bool has_it = heard.sender_ipv4 == ipv4_;
  const bool wants_it = heard.is_request && heard.sender_ipv4 == 0 && heard.target_ipv4 == ipv4_;
  if (!address()) {
    // While asking, somebody else who asks for the same is a conflict too.
    if (has_it || wants_it) {
      ++conflicts_;
      choose(now_ns);
    }
    return std::nullopt;
  }
  if (!has_it) return std::nullopt;  // the kernel answers probes for an address that a card has
  ++conflicts_;
  if (conflict_ns_ && now_ns - *conflict_ns_ < kDefend_ns) {
    choose(now_ns);
    return std::nullopt;
  }
  conflict_ns_ = now_ns;
  return Arp{true, mac_, ipv4_, ipv4_};
}

}  // namespace g3d::hal::boot
