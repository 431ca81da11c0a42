// SPDX-License-Identifier: Apache-2.0
// Sites of robots that a broker joins. The first robot of a site is its base station, which has two ways out: the air
// of the site, which loses nothing, and the broker. All in real time, as the broker is real.
#pragma once

#include <chrono>
#include <memory>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "hal/clock.hpp"
#include "hal/sim/seeded_random.hpp"
#include "net/datagram_gate.hpp"
#include "net/fleet_radio.hpp"
#include "net/gossip.hpp"
#include "net/mqtt_port.hpp"
#include "net/port_mux.hpp"
#include "tests/support/gate_fleet.hpp"
#include "tests/support/memory_air.hpp"

namespace g3d::test {

/// The same for all robots of the test.
struct SitesSetting {
  std::uint16_t broker_port = 0;
  double broker_bandwidth_Bps = 250'000.0;
  net::MqttPortOptions mqtt;
};

class SiteRobot {
 public:
  /// `mqtt`: the way to the broker of a base station, nullptr for others.
  SiteRobot(const net::FleetKey& keys, std::uint64_t robot, MemoryAir& air, std::size_t place, net::MqttPort* mqtt,
            double broker_bandwidth_Bps)
      : air_port_(air, place + 1),
        mux_([&] {
          std::vector<net::PortMux::Branch> branches{{&air_port_, 0.0}};
          if (mqtt != nullptr) branches.push_back({mqtt, broker_bandwidth_Bps});
          return branches;
        }()),
        gate(copy_of(keys), {.robot = robot, .incarnation = robot + 40}),
        radio_(gate, mux_),
        store({16, 1U << 15, std::size_t{4} << 20}),
        gossip(
            [&] {
              net::GossipOptions options;
              options.self = {robot, 1};
              options.seed = robot;
              options.beacon_period_ns = 100'000'000;
              return options;
            }(),
            store, radio_) {}

  void step(hal::TimeNs now_ns) {
    mux_.on_time(now_ns);
    radio_.receive(
        now_ns, [&](const net::Sender& from, mapper::ByteSpan message) { gossip.on_message(from, message, now_ns); });
    gossip.on_time(now_ns);
  }
  /// So many records, each of `bytes` bytes of chance; all with their keys from `first` on.
  void publish(std::uint64_t first, int records, std::size_t bytes, hal::TimeNs now_ns) {
    mapper::Bytes payload(bytes);
    for (int r = 0; r < records; ++r) {
      for (std::uint8_t& byte : payload) byte = static_cast<std::uint8_t>(random_.bits());
      (void)gossip.publish(net::block_record(0, first + static_cast<std::uint64_t>(r), net::Part::whole),
                           net::Lane::ground, payload);
    }
    gossip.commit(now_ns);
  }
  [[nodiscard]] const net::PortMux& mux() const { return mux_; }

 private:
  MemoryAir::Port air_port_;
  net::PortMux mux_;

 public:
  net::DatagramGate gate;

 private:
  net::FleetRadio radio_;
  hal::SeededRandom random_{1};

 public:
  net::LayerStore store;
  net::Gossip gossip;
};

/// `sites` sites of `robots` robots; robot i of site s is robots[s * robots + i].
class BrokerSites {
 public:
  BrokerSites(std::size_t sites, std::size_t robots_each, const SitesSetting& setting)
      : keys(net::generate_fleet_key()) {
    for (std::size_t s = 0; s < sites; ++s) {
      airs_.push_back(std::make_unique<MemoryAir>());
      net::MqttPortOptions options = setting.mqtt;
      options.host = "127.0.0.1";
      options.port = setting.broker_port;
      options.site = s + 1;
      auto opened = net::MqttPort::open(options);
      if (!opened) throw std::runtime_error(opened.error().text);
      ports.push_back(std::move(opened).value());
      for (std::size_t i = 0; i < robots_each; ++i) {
        robots.push_back(std::make_unique<SiteRobot>(keys, 16 * (s + 1) + i, *airs_.back(), i,
                                                     i == 0 ? ports.back().get() : nullptr,
                                                     setting.broker_bandwidth_Bps));
      }
    }
  }

  [[nodiscard]] hal::TimeNs now_ns() const { return clock_.now(); }
  void step() {
    for (const auto& robot : robots) robot->step(now_ns());
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  void run(hal::TimeNs duration_ns) {
    for (const hal::TimeNs end_ns = now_ns() + duration_ns; now_ns() < end_ns;) step();
  }
  [[nodiscard]] bool are_equal() const {
    for (const auto& robot : robots) {
      if (robot->store.digest() != robots.front()->store.digest()) return false;
    }
    return true;
  }
  template <class Done>
  [[nodiscard]] bool run_until(hal::TimeNs limit_ns, Done&& done) {
    for (const hal::TimeNs end_ns = now_ns() + limit_ns; now_ns() < end_ns;) {
      if (done()) return true;
      step();
    }
    return done();
  }
  [[nodiscard]] bool run_until_equal(hal::TimeNs limit_ns) {
    return run_until(limit_ns, [this] { return are_equal(); });
  }

  net::FleetKey keys;

 private:
  std::vector<std::unique_ptr<MemoryAir>> airs_;
  hal::RealClock clock_;

 public:
  std::vector<std::unique_ptr<net::MqttPort>> ports;  ///< by site
  std::vector<std::unique_ptr<SiteRobot>> robots;
};

}  // namespace g3d::test
