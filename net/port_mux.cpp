// SPDX-License-Identifier: Apache-2.0
#include "net/port_mux.hpp"

#include <algorithm>

#include "net/datagram_seal.hpp"

namespace g3d::net {
namespace {

constexpr unsigned kBranchShift = 56;
/// What may be sent at once after a pause.
constexpr double kBranchBurst_s = 0.02;

double burst_bytes(double bandwidth_Bps) {
  return std::max(2.0 * static_cast<double>(kMostDatagram_bytes), bandwidth_Bps * kBranchBurst_s);
}

}  // namespace

PortMux::PortMux(const std::vector<Branch>& branches) {
  for (const Branch& branch : branches) lanes_.push_back({branch, burst_bytes(branch.bandwidth_Bps), {}});
}

void PortMux::on_time(hal::TimeNs now_ns) {
  const double passed_s = 1e-9 * static_cast<double>(std::max<hal::TimeNs>(now_ns - now_ns_, 0));
  now_ns_ = std::max(now_ns, now_ns_);
  for (Lane& lane : lanes_) {
    const double rate_Bps = lane.branch.bandwidth_Bps;
    lane.allowance_bytes = std::min(lane.allowance_bytes + rate_Bps * passed_s, burst_bytes(rate_Bps));
  }
}

bool PortMux::send_by(Lane& lane, Address to, mapper::ByteSpan datagram) {
  const double rate_Bps = lane.branch.bandwidth_Bps;
  // Who asks has_room() stops at 0; what cannot wait, such as a beacon, may go into debt.
  if (rate_Bps > 0.0 && lane.allowance_bytes < -burst_bytes(rate_Bps)) {
    ++lane.counts.over_bandwidth;
    return false;
  }
  if (!lane.branch.port->send(to, datagram)) {
    ++lane.counts.not_taken;
    return false;
  }
  lane.allowance_bytes -= static_cast<double>(datagram.size());
  ++lane.counts.sent;
  lane.counts.sent_bytes += datagram.size();
  return true;
}

bool PortMux::send(Address to, mapper::ByteSpan datagram) {
  if (to == kEverybody) {
    bool is_sent = false;
    for (Lane& lane : lanes_) is_sent = send_by(lane, kEverybody, datagram) || is_sent;
    return is_sent;
  }
  const auto branch = branch_of(to);
  return branch && send_by(lanes_[*branch], within_branch(to), datagram);
}

std::optional<DatagramPort::Received> PortMux::receive() {
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    const std::size_t branch = turn_++ % lanes_.size();
    Lane& lane = lanes_[branch];
    auto received = lane.branch.port->receive();
    if (!received) continue;
    if (received->from == kEverybody || received->from > kMostPortAddress) {
      ++lane.counts.foreign_addresses;
      continue;
    }
    ++lane.counts.received;
    received->from |= (Address{branch} + 1) << kBranchShift;
    return received;
  }
  return std::nullopt;
}

bool PortMux::has_room(Address to) const {
  const auto has_room_in = [&](const Lane& lane, Address within) {
    return (lane.branch.bandwidth_Bps <= 0.0 || lane.allowance_bytes > 0.0) && lane.branch.port->has_room(within);
  };
  if (const auto branch = branch_of(to)) return has_room_in(lanes_[*branch], within_branch(to));
  return std::any_of(lanes_.begin(), lanes_.end(), [&](const Lane& lane) { return has_room_in(lane, kEverybody); });
}

std::optional<std::size_t> PortMux::branch_of(Address address) const {
  const std::size_t number = address >> kBranchShift;
  if (number == 0 || number > lanes_.size()) return std::nullopt;
  return number - 1;
}

}  // namespace g3d::net
