// SPDX-License-Identifier: Apache-2.0
// A robot as far as sharing goes, over whatever port: store, gossip, radio and gate. What its gossip says is kept, so
// that a test can look for it on the wire.
#pragma once

#include <string>

#include "net/fleet_radio.hpp"
#include "net/gossip.hpp"
#include "tests/support/gate_fleet.hpp"

namespace g3d::test {

class RadioGossip final : public net::Link {
 public:
  RadioGossip(net::DatagramPort& port, const net::FleetKey& keys, const net::LayerId& self,
              const net::GateSettings& settings = {})
      : gate(copy_of(keys), with_identity(settings, self)),
        radio(gate, port),
        store({16, 1U << 12, std::size_t{1} << 20}),
        gossip(options_of(self), store, *this) {}

  void step(hal::TimeNs now_ns) {
    (void)radio.receive(now_ns, [&](const net::Sender& sender, mapper::ByteSpan message) {
      gossip.on_message(sender, message, now_ns);
    });
    gossip.on_time(now_ns);
  }
  bool send(net::Address to, mapper::ByteSpan message) override {
    said.append(message.begin(), message.end());
    return radio.send(to, message);
  }
  /// Records with texts of known words in them, under keys from `first_key`.
  void publish(int records, std::uint64_t first_key, hal::TimeNs now_ns) {
    for (int i = 0; i < records; ++i) {
      const std::string text = std::string(kWords) + " " + std::to_string(first_key + static_cast<std::uint64_t>(i));
      const net::RecordKey key = net::block_record(0, first_key + static_cast<std::uint64_t>(i), net::Part::whole);
      (void)gossip.publish(key, net::kAllLanes[static_cast<std::size_t>(i) % net::kLanes],
                           {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
    }
    gossip.commit(now_ns);
  }

  static constexpr std::string_view kWords = "this wall has a door behind which the safe stands, number";

  std::string said;  ///< all messages that gossip sent, one after another
  net::DatagramGate gate;
  net::FleetRadio radio;
  net::LayerStore store;
  net::Gossip gossip;

 private:
  static net::GateSettings with_identity(net::GateSettings settings, const net::LayerId& self) {
    settings.robot = self.robot;
    settings.incarnation = self.incarnation;
    return settings;
  }
  static net::GossipOptions options_of(const net::LayerId& self) {
    net::GossipOptions options;
    options.self = self;
    options.seed = self.robot;
    return options;
  }
};

}  // namespace g3d::test
