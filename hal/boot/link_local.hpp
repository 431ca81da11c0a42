// SPDX-License-Identifier: Apache-2.0
// An IPv4 address without anybody who gives one out: 169.254/16, chosen from the card's own address, asked for with ARP
// before it is used, and given up for another one where somebody has it (RFC 3927). Plain: packets in, packets out; no
// socket. One thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "hal/messages.hpp"

namespace g3d::hal::boot {

using MacAddress = std::array<std::uint8_t, 6>;
/// ARP over Ethernet for IPv4, without the Ethernet header (RFC 826).
using ArpPacket = std::array<std::uint8_t, 28>;

struct Arp {
  bool is_request = true;
  MacAddress sender_mac{};
  std::uint32_t sender_ipv4 = 0;  ///< host byte order, as below; 0: a probe
  std::uint32_t target_ipv4 = 0;
};
[[nodiscard]] ArpPacket encode_arp(const Arp& arp);
/// Nothing if it is no ARP request or reply of that kind. Longer ones are padded: the rest does not count.
[[nodiscard]] std::optional<Arp> decode_arp(std::span<const std::uint8_t> bytes);

class LinkLocal {
 public:
  // RFC 3927, section 9
  static constexpr int kProbes = 3;
  static constexpr TimeNs kProbePeriod_ns = 1'000'000'000;  ///< PROBE_MIN; each is drawn between it and twice as much
  static constexpr TimeNs kAnnounceWait_ns = 2'000'000'000;
  static constexpr int kAnnouncements = 2;
  static constexpr int kMostConflicts = 10;
  static constexpr TimeNs kRateLimit_ns = 60'000'000'000;
  static constexpr TimeNs kDefend_ns = 10'000'000'000;

  LinkLocal(const MacAddress& mac, TimeNs now_ns);

  /// What to send now, if anything. Call at next_ns() or before.
  [[nodiscard]] std::optional<Arp> on_time(TimeNs now_ns);
  [[nodiscard]] TimeNs next_ns() const { return next_ns_; }
  /// Everything that was heard on this card, our own packets too. What to send to defend the address, if anything.
  [[nodiscard]] std::optional<Arp> on_arp(const Arp& heard, TimeNs now_ns);

  /// Host byte order. Nothing while it is asked for; then the card may have it.
  [[nodiscard]] std::optional<std::uint32_t> address() const;
  [[nodiscard]] int conflicts() const { return conflicts_; }

 private:
  void choose(TimeNs now_ns);
  [[nodiscard]] std::uint64_t draw();

  MacAddress mac_;
  std::uint64_t random_;
  std::uint32_t ipv4_ = 0;
  int sent_ = 0;  ///< probes, then announcements
  int conflicts_ = 0;
  TimeNs next_ns_ = 0;
  std::optional<TimeNs> conflict_ns_;
};

}  // namespace g3d::hal::boot
