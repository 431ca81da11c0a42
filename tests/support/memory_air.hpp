// SPDX-License-Identifier: Apache-2.0
// Ports that hear each other in memory, at once and without loss: for tests of what stands above a port. Everything
// that was sent is kept, as by somebody who listens; anything can be put into a port's way.
#pragma once

#include <deque>
#include <map>
#include <utility>
#include <vector>

#include "net/datagram_port.hpp"

namespace g3d::test {

class MemoryAir {
 public:
  class Port final : public net::DatagramPort {
   public:
    Port(MemoryAir& air, net::Address own) : air_(air), own_(own) { air_.ports_[own] = this; }
    ~Port() override { air_.ports_.erase(own_); }
    bool send(net::Address to, mapper::ByteSpan datagram) override {
      if (is_down) return false;
      const mapper::Bytes bytes(datagram.begin(), datagram.end());
      air_.heard.emplace_back(own_, bytes);
      for (const auto& [address, port] : air_.ports_) {
        if (to == net::kEverybody ? address != own_ : address == to) port->inbox.emplace_back(own_, bytes);
      }
      return true;
    }
    std::optional<Received> receive() override {
      if (inbox.empty()) return std::nullopt;
      now_ = std::move(inbox.front());
      inbox.pop_front();
      return Received{now_.first, now_.second};
    }
    [[nodiscard]] net::Address address() const { return own_; }

    std::deque<std::pair<net::Address, mapper::Bytes>> inbox;
    bool is_down = false;

   private:
    MemoryAir& air_;
    const net::Address own_;
    std::pair<net::Address, mapper::Bytes> now_;
  };

  std::vector<std::pair<net::Address, mapper::Bytes>> heard;

 private:
  std::map<net::Address, Port*> ports_;
};

}  // namespace g3d::test
