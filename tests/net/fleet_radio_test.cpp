// SPDX-License-Identifier: Apache-2.0
#include "net/fleet_radio.hpp"

#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/gate_fleet.hpp"
#include "tests/support/memory_air.hpp"

using namespace g3d;
using net::FleetRadio;
using test::MemoryAir;

namespace {

constexpr hal::TimeNs kRadioMs_ns = 1'000'000;

/// One start of a robot's program.
struct RadioRobot {
  RadioRobot(MemoryAir& air, const net::FleetKey& keys, std::uint64_t robot, std::uint64_t incarnation = 1)
      : port(air, 500 + robot),
        gate(test::copy_of(keys), {.robot = robot, .incarnation = incarnation}),
        radio(gate, port) {}
  std::size_t listen(hal::TimeNs now_ns) {
    return radio.receive(now_ns, [this](const net::Sender& sender, mapper::ByteSpan message) {
      heard.emplace_back(sender, std::string(message.begin(), message.end()));
    });
  }
  bool say(net::Address to, std::string_view text) {
    return radio.send(to, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  }
  MemoryAir::Port port;
  net::DatagramGate gate;
  FleetRadio radio;
  std::vector<std::pair<net::Sender, std::string>> heard;
};

/// Says it until it is heard: the first time a stranger only shows that it is one of us.
bool is_heard(RadioRobot& from, RadioRobot& to, std::string_view text, hal::TimeNs now_ns) {
  const std::size_t before = to.heard.size();
  for (int tries = 0; tries < 2; ++tries) {
    (void)from.say(net::kEverybody, text);
    for (int turns = 0; turns < 3; ++turns) (void)(to.listen(now_ns) + from.listen(now_ns));
  }
  return to.heard.size() == before + 1;
}

}  // namespace

TEST_CASE("a message reaches the others with its sender, once they know each other") {
  const net::FleetKey keys = net::generate_fleet_key();
  MemoryAir air;
  RadioRobot a(air, keys, 1), b(air, keys, 2), c(air, keys, 3);
  REQUIRE(a.say(net::kEverybody, "hello"));
  CHECK(b.listen(0) == 1);
  CHECK(b.heard.empty());
  for (int turns = 0; turns < 3; ++turns) (void)(a.listen(0) + b.listen(0) + c.listen(0));
  REQUIRE(a.say(net::kEverybody, "hello again"));
  (void)(b.listen(0) + c.listen(0));
  for (const RadioRobot* robot : {&b, &c}) {
    REQUIRE(robot->heard.size() == 1);
    const auto& [sender, text] = robot->heard[0];
    CHECK(text == "hello again");
    CHECK(sender.robot == 1);
    CHECK(sender.address == a.port.address());
    CHECK(sender.session == a.gate.own_session());
  }
  // The address is good for an answer to that one alone.
  REQUIRE(is_heard(b, a, "x", 0));
  const std::size_t at_c = c.port.inbox.size();
  REQUIRE(b.say(b.heard[0].first.address, "to you"));
  (void)a.listen(0);
  CHECK(a.heard.back().second == "to you");
  CHECK(c.port.inbox.size() == at_c);
  CHECK(b.radio.counts().delivered == 1);
  CHECK(b.radio.counts().answered >= 1);
}

TEST_CASE("nothing that was said can be read off the air, and what is put into it reaches nobody") {
  const net::FleetKey keys = net::generate_fleet_key();
  MemoryAir air;
  RadioRobot a(air, keys, 1), b(air, keys, 2);
  const std::string text = "the door of room 12 stands open";
  REQUIRE(is_heard(a, b, text, 0));
  for (const auto& [from, datagram] : air.heard) {
    const std::string seen(datagram.begin(), datagram.end());
    for (std::size_t at = 0; at + 4 <= text.size(); ++at) CHECK(seen.find(text.substr(at, 4)) == std::string::npos);
  }
  const std::size_t before = b.heard.size();
  const auto recorded = air.heard;
  for (const auto& [from, datagram] : recorded) b.port.inbox.emplace_back(from, datagram);
  for (const auto& [from, datagram] : recorded) b.port.inbox.emplace_back(666, datagram);
  b.port.inbox.emplace_back(a.port.address(), mapper::Bytes{});
  b.port.inbox.emplace_back(a.port.address(), mapper::Bytes(5000, 1));
  CHECK(b.listen(kRadioMs_ns) == 2 * recorded.size() + 2);
  CHECK(b.heard.size() == before);
  CHECK(b.radio.counts().received == b.gate.counts().taken());
}

TEST_CASE("a robot that starts anew is heard with another session, whether it goes on with its layer or not") {
  const std::uint64_t incarnation = GENERATE(1, 2);
  const net::FleetKey keys = net::generate_fleet_key();
  MemoryAir air;
  RadioRobot b(air, keys, 2);
  auto a = std::make_unique<RadioRobot>(air, keys, 1);
  REQUIRE(is_heard(*a, b, "before", 0));
  const auto of_before = air.heard;
  a.reset();
  a = std::make_unique<RadioRobot>(air, keys, 1, incarnation);
  REQUIRE(is_heard(*a, b, "after", 1000 * kRadioMs_ns));
  REQUIRE(b.heard.size() == 2);
  CHECK(b.heard[0].first.robot == b.heard[1].first.robot);
  CHECK(b.heard[0].first.session != b.heard[1].first.session);
  // What the earlier start had sent comes no more.
  for (const auto& [from, datagram] : of_before) b.port.inbox.emplace_back(from, datagram);
  (void)b.listen(2000 * kRadioMs_ns);
  CHECK(b.heard.size() == 2);
}

TEST_CASE("whoever is spoken to may answer at once, and what it was told stays as it was") {
  const net::FleetKey keys = net::generate_fleet_key();
  MemoryAir air;
  RadioRobot a(air, keys, 1), b(air, keys, 2);
  REQUIRE(is_heard(a, b, "x", 0));
  REQUIRE(a.say(net::kEverybody, "what was said"));
  std::string told;
  (void)b.radio.receive(0, [&](const net::Sender& sender, mapper::ByteSpan message) {
    for (int i = 0; i < 3; ++i) REQUIRE(b.say(sender.address, "something else entirely"));
    told.assign(message.begin(), message.end());
  });
  CHECK(told == "what was said");
}

TEST_CASE("how much is read at a time is bounded") {
  const net::FleetKey keys = net::generate_fleet_key();
  MemoryAir air;
  RadioRobot b(air, keys, 2);
  for (std::size_t i = 0; i < 2 * FleetRadio::kMostAtOnce + 10; ++i) b.port.inbox.emplace_back(9, mapper::Bytes(40, 1));
  CHECK(b.listen(0) == FleetRadio::kMostAtOnce);
  CHECK(b.listen(0) == FleetRadio::kMostAtOnce);
  CHECK(b.listen(0) == 10);
  CHECK(b.listen(0) == 0);
}

TEST_CASE("what cannot leave is counted by what kept it") {
  const net::FleetKey keys = net::generate_fleet_key();
  MemoryAir air;
  RadioRobot a(air, keys, 1), b(air, keys, 2);
  CHECK_FALSE(a.say(net::kEverybody, std::string(net::kMostPlaintext_bytes + 1, 'x')));
  CHECK(a.radio.counts().not_sealed == 1);
  CHECK(a.say(net::kEverybody, std::string(net::kMostPlaintext_bytes, 'x')));
  CHECK(a.radio.counts().sent == 1);
  CHECK(a.radio.counts().sent_bytes == net::kMostDatagram_bytes);
  b.port.is_down = true;
  CHECK(b.listen(0) == 1);
  CHECK(b.radio.counts().not_answered == 1);
  CHECK_FALSE(b.say(net::kEverybody, "x"));
  CHECK(b.radio.counts().not_sent == 1);
}
