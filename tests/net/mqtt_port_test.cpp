// SPDX-License-Identifier: Apache-2.0
#include "net/mqtt_port.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstring>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "tests/net/broker_sites.hpp"
#include "tests/support/broker_process.hpp"

namespace {

using namespace g3d;
using namespace g3d::net;
using namespace g3d::test;

constexpr hal::TimeNs kBrokerSecond_ns = 1'000'000'000;

bool port_tests_have_broker() {
  const std::string missing = BrokerProcess::what_is_missing();
  if (!missing.empty()) WARN("this case did not run: " << missing);
  return missing.empty();
}

MqttPortOptions quick_options(const BrokerProcess& broker, SiteId site) {
  MqttPortOptions options;
  options.host = "127.0.0.1";
  options.port = broker.port();
  options.site = site;
  options.first_pause_ns = 20'000'000;
  options.longest_pause_ns = 100'000'000;
  return options;
}

std::unique_ptr<MqttPort> opened(const MqttPortOptions& options) {
  auto port = MqttPort::open(options);
  if (!port) throw std::runtime_error(port.error().text);
  return std::move(port).value();
}

template <class Done>
bool soon(Done&& done) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!done()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

mapper::Bytes numbered(std::uint32_t number, std::size_t bytes) {
  mapper::Bytes datagram(bytes, static_cast<std::uint8_t>(number));
  std::memcpy(datagram.data(), &number, sizeof number);
  return datagram;
}

/// A client of the broker that is none of ours: it says what it likes, under any topic.
class Stranger {
 public:
  explicit Stranger(const BrokerProcess& broker) {
    hal::MqttSettings settings;
    settings.host = "127.0.0.1";
    settings.port = broker.port();
    settings.client_id = "stranger";
    settings.subscriptions = {"#"};
    auto made = hal::MqttClient::make(settings, [this](std::string_view topic, mapper::ByteSpan payload) {
      heard.emplace_back(std::string(topic), mapper::Bytes(payload.begin(), payload.end()));
    });
    if (!made) throw std::runtime_error(made.error().text);
    client_ = std::move(made).value();
    if (!client_->connect() || !soon([&] { return client_->serve(true, true) && client_->is_ready(); })) {
      throw std::runtime_error(client_->last_fault());
    }
  }
  void listen() { (void)client_->serve(true, true); }
  void say(const std::string& topic, mapper::ByteSpan payload) {
    CHECK(client_->publish(topic, 0, payload, 60));
    for (int i = 0; client_->wants_write() && i < 1000; ++i) (void)client_->serve(false, true);
  }
  std::vector<std::pair<std::string, mapper::Bytes>> heard;

 private:
  std::unique_ptr<hal::MqttClient> client_;
};

TEST_CASE("options that no broker could be asked with are refused before anything is tried") {
  MqttPortOptions options;
  options.host = "127.0.0.1";
  options.site = 1;
  const auto refusal = [&] {
    const auto port = MqttPort::open(options);
    return port.ok() ? std::string("none") : port.error().text;
  };
  options.root = "a/+";
  CHECK_THAT(refusal(), Catch::Contains("'a/+' is no root of topics"));
  options.root = "a";
  options.site = 0;
  CHECK_THAT(refusal(), Catch::Contains("site 0"));
  options.site = kMostSiteId + 1;
  CHECK_THAT(refusal(), Catch::Contains("take a number from 1 to ffffffffffffff"));
  options.site = 1;
  options.host = "broker.example.org";
  CHECK_THAT(refusal(), Catch::Contains(hal::MqttClient::is_built_in() ? "is no numeric IPv4 or IPv6 address"
                                                                       : "built without libmosquitto"));
}

TEST_CASE("every reason to drop a datagram has a name of its own") {
  std::set<std::string> names;
  for (std::size_t i = 0; i < kMqttDrops; ++i) names.insert(to_string(static_cast<MqttDrop>(i)));
  CHECK(names.size() == kMqttDrops);
  CHECK(names.count("unknown") == 0);
}

TEST_CASE("datagrams go to all sites or to one, whole and in order, many in a message", "[threads]") {
  if (!port_tests_have_broker()) return;
  BrokerProcess broker;
  broker.start();
  const auto a = opened(quick_options(broker, 0xA)), b = opened(quick_options(broker, 0xB)),
             c = opened(quick_options(broker, 0xC));
  REQUIRE(soon([&] { return a->is_connected() && b->is_connected() && c->is_connected(); }));
  constexpr std::uint32_t kCount = 200;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    CHECK(a->send(i % 4 == 0 ? kEverybody : 0xB, numbered(i, i == 7 ? kMostDatagram_bytes : 4 + i)));
  }
  std::vector<std::uint32_t> heard_b, heard_c;
  const auto take = [](MqttPort& port, std::vector<std::uint32_t>& heard) {
    while (const auto received = port.receive()) {
      CHECK(received->from == 0xA);
      std::uint32_t number = 0;
      std::memcpy(&number, received->datagram.data(), sizeof number);
      CHECK(numbered(number, received->datagram.size()) ==
            mapper::Bytes(received->datagram.begin(), received->datagram.end()));
      CHECK(received->datagram.size() == (number == 7 ? kMostDatagram_bytes : 4 + number));
      heard.push_back(number);
    }
  };
  CHECK(soon([&] {
    take(*b, heard_b);
    take(*c, heard_c);
    return heard_b.size() >= kCount && heard_c.size() >= kCount / 4;
  }));
  CHECK(heard_b.size() == kCount);
  CHECK(std::is_sorted(heard_c.begin(), heard_c.end()));
  CHECK(std::set<std::uint32_t>(heard_b.begin(), heard_b.end()).size() == kCount);
  const MqttPortCounts counts = a->counts();
  CHECK(counts.sent_datagrams == kCount);
  CHECK(counts.sent_messages <= kCount / 4);
  CHECK(counts.received_messages == 0);  // what a site says does not come back to it
  CHECK(b->counts().received_datagrams == kCount);
  // Answers find their way.
  CHECK(c->send(0xA, numbered(1, 10)));
  CHECK(soon([&] {
    const auto received = a->receive();
    return received && received->from == 0xC && received->datagram.size() == 10;
  }));
  CHECK_FALSE(a->send(0xB, {}));
  CHECK_FALSE(a->send(0xB, mapper::Bytes(kMostDatagram_bytes + 1)));
  CHECK(a->counts()[MqttDrop::bad_length] == 2);
}

TEST_CASE("a queue that is full says so before, then drops; nothing leaves without a broker", "[threads]") {
  if (!port_tests_have_broker()) return;
  BrokerProcess broker;
  MqttPortOptions options = quick_options(broker, 1);
  options.outgoing = 8;
  options.incoming = 8;
  options.linger_ns = 50'000'000;
  const auto a = opened(options);
  CHECK_FALSE(a->has_room(2));
  CHECK_FALSE(a->send(2, numbered(0, 10)));
  CHECK(a->counts()[MqttDrop::not_connected] == 1);
  CHECK(soon([&] { return a->counts().failed_connections >= 3; }));
  CHECK_THAT(a->last_fault(), Catch::Contains("Connection refused"));
  broker.start();
  options.site = 2;
  const auto b = opened(options);
  REQUIRE(soon([&] { return a->is_connected() && b->is_connected(); }));
  CHECK(a->has_room(2));
  // Nobody takes what comes at b: its ring fills, the rest is counted.
  std::uint64_t sent = 0;
  for (std::uint32_t i = 0; i < 100'000; ++i) sent += a->send(2, numbered(i, 100)) ? 1 : 0;
  CHECK(a->counts()[MqttDrop::outgoing_full] == 100'000 - sent);
  CHECK(sent >= 8);
  CHECK(sent < 100'000);
  CHECK(soon([&] { return a->counts().sent_datagrams == sent; }));
  std::uint64_t taken = 0;
  CHECK(soon([&] {
    while (b->receive()) ++taken;
    const MqttPortCounts counts = b->counts();
    return counts.received_datagrams + counts[MqttDrop::incoming_full] == sent && taken == counts.received_datagrams;
  }));
}

TEST_CASE("two sites of two robots share their layers through a broker, which dies and comes back", "[threads]") {
  if (!port_tests_have_broker()) return;
  BrokerProcess broker;
  broker.start();
  SitesSetting setting;
  setting.broker_port = broker.port();
  setting.mqtt = quick_options(broker, 1);
  BrokerSites sites(2, 2, setting);
  for (const auto& robot : sites.robots) robot->publish(0, 150, 100, sites.now_ns());
  REQUIRE(sites.run_until(10 * kBrokerSecond_ns, [&] { return sites.robots[3]->gossip.counts().stored_records > 20; }));
  // In the middle of it.
  CHECK_FALSE(sites.are_equal());
  broker.kill();
  CHECK(sites.run_until(10 * kBrokerSecond_ns, [&] { return !sites.ports[0]->is_connected(); }));
  for (const auto& robot : sites.robots) robot->publish(100, 150, 100, sites.now_ns());
  sites.run(kBrokerSecond_ns / 10);
  CHECK_FALSE(sites.are_equal());
  broker.start();
  CHECK(sites.run_until_equal(20 * kBrokerSecond_ns));
  for (const auto& robot : sites.robots) {
    CHECK(robot->store.layer_count() == 4);
    CHECK(robot->store.payload_bytes() == std::size_t{4} * 250 * 100);
  }
  for (const auto& port : sites.ports) {
    CHECK(port->counts().connections == 2);
    CHECK(port->counts()[MqttDrop::malformed_batch] == 0);
    CHECK(port->counts()[MqttDrop::incoming_full] == 0);
  }
}

TEST_CASE("a broker with the access list of the README lets every site speak in its own name alone") {
  if (!port_tests_have_broker()) return;
  TempFolder folder;
  const std::string users = folder / "users";
  write_plain(users, "");
  for (const char* user : {"1", "2", "7"}) {
    Program passwd("/usr/bin/mosquitto_passwd", {"-b", users, user, std::string("word of ") + user});
    REQUIRE(passwd.finish().exit_code == 0);
  }
  write_plain(folder / "access", "pattern write g3dmap/+/%u\npattern read g3dmap/all/+\npattern read g3dmap/%u/+\n");
  BrokerProcess broker("allow_anonymous false\npassword_file " + users + "\nacl_file " + (folder / "access") + "\n");
  broker.start();
  const auto open_as = [&](SiteId site, const std::string& user, const std::string& password) {
    MqttPortOptions options = quick_options(broker, site);
    options.user = user;
    options.password = password;
    return opened(options);
  };
  const auto one = open_as(1, "1", "word of 1"), two = open_as(2, "2", "word of 2");
  const auto liar = open_as(0x2A, "7", "word of 7"), guesser = open_as(3, "2", "word of 1");
  REQUIRE(soon([&] { return one->is_connected() && two->is_connected() && liar->is_connected(); }));
  CHECK(soon([&] { return guesser->counts().failed_connections > 0; }));
  CHECK_THAT(guesser->last_fault(), Catch::Contains("refused: Not authorized"));
  CHECK(liar->send(kEverybody, numbered(8, 10)));
  CHECK(liar->send(1, numbered(9, 10)));
  CHECK(soon([&] { return liar->counts().sent_datagrams == 2; }));
  CHECK(two->send(kEverybody, numbered(1, 10)));
  CHECK(two->send(1, numbered(2, 10)));
  std::multiset<Address> heard;
  CHECK(soon([&] {
    while (const auto received = one->receive()) heard.insert(received->from);
    return heard.size() >= 2;
  }));
  CHECK(heard == std::multiset<Address>{2, 2});
}

TEST_CASE("whoever else writes to our topics changes nothing, and learns nothing", "[threads]") {
  if (!port_tests_have_broker()) return;
  BrokerProcess broker;
  broker.start();
  SitesSetting setting;
  setting.broker_port = broker.port();
  setting.mqtt = quick_options(broker, 1);
  BrokerSites sites(2, 1, setting);
  Stranger stranger(broker);
  const mapper::Bytes plain(100, 0x5A);
  for (const auto& robot : sites.robots) {
    for (std::uint64_t i = 0; i < 50; ++i) {
      CHECK(robot->gossip.publish(block_record(0, i, Part::whole), Lane::ground, plain));
    }
    robot->gossip.commit(sites.now_ns());
  }
  CHECK(sites.run_until(20 * kBrokerSecond_ns, [&] {
    stranger.listen();
    return sites.are_equal();
  }));
  REQUIRE(stranger.heard.size() > 10);
  std::size_t recordings = 0;
  for (const auto& [topic, payload] : stranger.heard) {
    CHECK(std::search(payload.begin(), payload.end(), plain.begin(), plain.begin() + 16) == payload.end());
    recordings += datagrams_of(payload);
  }
  const std::uint64_t digest = sites.robots[0]->store.digest();
  const auto delivered = [&] { return sites.robots[0]->gate.counts().delivered; };
  const std::uint64_t applied = sites.robots[0]->gossip.counts().stored_records;

  // Recordings, with every topic; noise in right frames and in wrong ones; and topics that are none.
  const auto recorded = std::vector<std::pair<std::string, mapper::Bytes>>(stranger.heard);
  hal::SeededRandom random(5);
  std::uint64_t malformed = 0, foreign = 0;
  for (const auto& [topic, payload] : recorded) {
    stranger.say("g3dmap/1/2", payload);
    stranger.say("g3dmap/all/7f", payload);
    mapper::Bytes flipped = payload;
    flipped[2 + random.bits() % (flipped.size() - 2)] ^= 0x10;
    stranger.say("g3dmap/1/2", flipped);
    malformed += datagrams_of(flipped) == 0 ? 1 : 0;
    mapper::Bytes noise;
    for (int i = 0; i < 5; ++i)
      append_datagram(noise, numbered(static_cast<std::uint32_t>(random.bits()), 40 + 100 * i));
    stranger.say("g3dmap/1/2", noise);
    noise.pop_back();
    stranger.say("g3dmap/1/2", noise);
    stranger.say("g3dmap/all/2", {});
    malformed += 2;
    for (const char* name : {"g3dmap/1/1", "g3dmap/1/x", "g3dmap/all/0", "g3dmap/all/02", "g3dmap/1/100000000000000"}) {
      stranger.say(name, payload);
      ++foreign;
    }
    stranger.say("g3dmap/2/1/1", payload);
    stranger.say("elsewhere/1/2", payload);
    sites.step();
    stranger.listen();
  }
  const std::uint64_t before = delivered();
  CHECK(soon([&] {
    sites.step();
    return sites.ports[0]->counts()[MqttDrop::foreign_topic] >= foreign;
  }));
  sites.run(kBrokerSecond_ns / 5);
  const GateCounts gate = sites.robots[0]->gate.counts();
  CHECK(sites.ports[0]->counts()[MqttDrop::malformed_batch] == malformed);
  CHECK(sites.ports[0]->counts()[MqttDrop::foreign_topic] == foreign);
  CHECK(gate.refused() >= recordings);
  CHECK(gate[GateRefusal::forged] + gate[GateRefusal::unknown_format] + gate[GateRefusal::source_rate] >
        recorded.size());
  CHECK(sites.robots[0]->gossip.counts().stored_records == applied);
  CHECK(sites.robots[0]->store.digest() == digest);
  CHECK(sites.are_equal());
  // And the sites still hear each other.
  sites.robots[1]->publish(1000, 20, 50, sites.now_ns());
  CHECK(sites.run_until_equal(20 * kBrokerSecond_ns));
  CHECK(delivered() > before);
}

}  // namespace
