// SPDX-License-Identifier: Apache-2.0
// A relay between real sockets that mistreats datagrams by a seed: loses, doubles, delays, lets them overtake each
// other, flips bits, cuts off ends, and cuts links on a schedule. For every ordered pair of robots there is a door:
//
//   robot i ──▶ door (i, j) ··· relay ··· door (j, i) ──▶ robot j, which answers to where it came from
//
// so that each robot sees every other one at an address of its own, and whatever it says passes through here. All that
// robots sent is kept, as by somebody who listens. The same seed and the same datagrams in the same order meet the same
// fate. One thread, which calls pump().
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hal/linux/udp_socket.hpp"
#include "net/sim_radio.hpp"

namespace g3d::test {

struct RelayModel {
  net::RadioModel radio;
  double flipped = 0.0;    ///< share of datagrams of which a bit is another
  double truncated = 0.0;  ///< share of datagrams of which the end is missing
};

/// Between `a` and `b` nothing passes, in neither direction, from `from_ns` until `until_ns`.
struct RelayCut {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  hal::TimeNs from_ns = 0;
  hal::TimeNs until_ns = 0;
};

struct RelayCounts {
  std::uint64_t flipped = 0;
  std::uint64_t truncated = 0;
  std::uint64_t nowhere = 0;  ///< for a robot that has not spoken yet
};

class DatagramRelay {
 public:
  DatagramRelay(std::uint32_t robots, const RelayModel& model, std::vector<RelayCut> cuts = {});

  /// What robot `i` is to configure as its peers: "127.0.0.1:port" each.
  [[nodiscard]] std::vector<std::string> peers_of(std::uint32_t i) const;
  /// Takes what has come, and hands over what is due.
  void pump(hal::TimeNs now_ns);

  struct Captured {
    std::uint32_t from = 0;
    std::uint32_t to = 0;
    mapper::Bytes datagram;  ///< as it was sent, before anything happened to it
  };
  [[nodiscard]] const std::vector<Captured>& capture() const { return capture_; }
  /// Once more the same to the same robot, as if from the same one; at once.
  void replay(const Captured& captured) { hand_over(captured.from, captured.to, captured.datagram); }

  void set_model(const RelayModel& model);
  [[nodiscard]] const net::SimRadio& radio() const { return radio_; }
  [[nodiscard]] const RelayCounts& counts() const { return counts_; }

 private:
  [[nodiscard]] hal::UdpSocket& door(std::uint32_t from, std::uint32_t to) const {
    return *doors_[from * robots_ + to];
  }
  void take(std::uint32_t from, std::uint32_t to, mapper::ByteSpan datagram, hal::TimeNs now_ns);
  void hand_over(std::uint32_t from, std::uint32_t to, mapper::ByteSpan datagram);

  std::uint32_t robots_;
  RelayModel model_;
  std::vector<RelayCut> cuts_;
  net::SimRadio radio_;
  hal::SeededRandom random_;
  std::vector<std::unique_ptr<hal::UdpSocket>> doors_;
  std::vector<hal::Ipv4Endpoint> where_;  ///< each robot spoke from last; port 0: has not yet
  std::vector<Captured> capture_;
  RelayCounts counts_;
};

}  // namespace g3d::test
