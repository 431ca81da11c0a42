// SPDX-License-Identifier: Apache-2.0
// Several ports as one, such as the fleet's radio and the way to a broker: what is for everybody leaves by all of them,
// an answer by the one that it came from, so that one gossip passes layers on between them. Each may have a bandwidth
// of its own. Addresses carry the number of their port in their highest byte. One thread; never waits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "hal/messages.hpp"
#include "net/datagram_port.hpp"

namespace g3d::net {

/// A port behind a mux gives addresses up to here.
inline constexpr Address kMostPortAddress = (Address{1} << 56U) - 1;

class PortMux final : public DatagramPort {
 public:
  struct Branch {
    DatagramPort* port = nullptr;  ///< outlives the mux
    double bandwidth_Bps = 0.0;    ///< of datagrams; 0: no limit here
  };
  struct BranchCounts {
    std::uint64_t sent = 0;
    std::uint64_t sent_bytes = 0;
    std::uint64_t over_bandwidth = 0;  ///< not sent for it
    std::uint64_t not_taken = 0;       ///< by the port, which says why
    std::uint64_t received = 0;
    std::uint64_t foreign_addresses = 0;  ///< received from beyond kMostPortAddress, and dropped
  };

  /// At most 255.
  explicit PortMux(const std::vector<Branch>& branches);

  /// Bandwidth is given as time passes: to be called before what is sent then.
  void on_time(hal::TimeNs now_ns);

  /// To everybody: true if any port took it.
  bool send(Address to, mapper::ByteSpan datagram) override;
  /// From the ports in turns: a flood at one does not silence the others.
  [[nodiscard]] std::optional<Received> receive() override;
  [[nodiscard]] bool has_room(Address to) const override;

  /// Which branch an address belongs to; nothing for kEverybody and what is none of ours.
  [[nodiscard]] std::optional<std::size_t> branch_of(Address address) const;
  /// What the branch itself calls it.
  [[nodiscard]] static Address within_branch(Address address) { return address & kMostPortAddress; }
  [[nodiscard]] const BranchCounts& counts(std::size_t branch) const { return lanes_[branch].counts; }

 private:
  struct Lane {
    Branch branch;
    double allowance_bytes = 0.0;
    BranchCounts counts;
  };
  bool send_by(Lane& lane, Address to, mapper::ByteSpan datagram);

  std::vector<Lane> lanes_;
  hal::TimeNs now_ns_ = 0;
  std::size_t turn_ = 0;
};

}  // namespace g3d::net
