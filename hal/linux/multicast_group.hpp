// SPDX-License-Identifier: Apache-2.0
// One socket's membership in a multicast group, on one interface by name or on all that can. Radios come and go, and
// one that came back has to be joined anew: refresh() does, whenever it is called. One thread; nothing allocates after
// construction.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "hal/linux/ipv4_interfaces.hpp"
#include "hal/linux/udp_socket.hpp"

namespace g3d::hal {

struct MulticastCounts {
  std::uint64_t joined = 0;   ///< how often an interface was joined
  std::uint64_t left = 0;     ///< how often one that had been joined was gone
  std::uint64_t refused = 0;  ///< how often the system would not join one
};

class MulticastGroup {
 public:
  /// `fd`: a bound UDP socket that outlives this. `interface`: its name; empty: every one that is up and can, and the
  /// loopback one if there is no other.
  MulticastGroup(int fd, std::uint32_t group_ipv4, std::string interface);

  /// Looks what there is, joins what is new and leaves what is gone.
  void refresh();
  /// The interfaces that are joined now, each with its own address.
  [[nodiscard]] std::span<const Leaving> joined() const { return {joined_.data(), joined_count_}; }
  [[nodiscard]] const MulticastCounts& counts() const { return counts_; }

 private:
  [[nodiscard]] bool is_wanted(const Ipv4Interface& one, bool has_other) const;
  [[nodiscard]] bool change(int option, int index) const;

  int fd_;
  std::uint32_t group_ipv4_;
  std::string interface_;
  std::array<Leaving, Ipv4Interfaces::kMost> joined_{};
  std::size_t joined_count_ = 0;
  MulticastCounts counts_;
};

}  // namespace g3d::hal
