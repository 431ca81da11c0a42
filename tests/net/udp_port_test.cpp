// SPDX-License-Identifier: Apache-2.0
#include "net/udp_port.hpp"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/support/own_network.hpp"

using namespace g3d;
using hal::Reason;
using net::UdpPort;
using net::UdpPortOptions;

namespace {

constexpr hal::TimeNs kPatience_ns = 2'000'000'000;

/// Robots of one test on this machine; other tests that run at the same time have other groups.
UdpPortOptions on_this_machine() {
  UdpPortOptions options;
  options.interface = "lo";
  options.port = 0;
  options.group = "239.255." + std::to_string(::getpid() / 200 % 200 + 1) + "." + std::to_string(::getpid() % 200 + 1);
  return options;
}

std::unique_ptr<UdpPort> opened(const UdpPortOptions& options) {
  auto port = UdpPort::open(options);
  if (!port) FAIL(port.error().text);
  return std::move(port).value();
}

struct Heard {
  net::Address from = net::kEverybody;
  std::string text;
};
/// All that has come, once there are `wanted`: on a busy machine it may take its time.
std::vector<Heard> all_heard(UdpPort& port, std::size_t wanted) {
  std::vector<Heard> heard;
  do {
    while (const auto received = port.receive()) {
      heard.push_back({received->from, {received->datagram.begin(), received->datagram.end()}});
    }
  } while (heard.size() < wanted && port.wait(kPatience_ns));
  return heard;
}

mapper::ByteSpan bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

}  // namespace

TEST_CASE("robots of one machine hear each other through the group and answer each other alone") {
  const auto a = opened(on_this_machine()), b = opened(on_this_machine()), c = opened(on_this_machine());
  REQUIRE(a->interfaces() == 1);
  REQUIRE(a->send(net::kEverybody, bytes_of("here I am")));
  REQUIRE(b->wait(kPatience_ns));
  const auto at_b = all_heard(*b, 1), at_c = all_heard(*c, 1);
  REQUIRE(at_b.size() == 1);
  REQUIRE(at_c.size() == 1);
  CHECK(at_b[0].text == "here I am");
  CHECK(at_b[0].from == UdpPort::address_of(0x7F000001, a->port()));
  REQUIRE(b->send(at_b[0].from, bytes_of("so am I")));
  // Its own word comes back to it as well: whoever listens knows its own.
  const auto at_a = all_heard(*a, 2);
  REQUIRE(at_a.size() == 2);
  CHECK(at_a[0].text != at_a[1].text);
  CHECK(all_heard(*c, 0).empty());
  CHECK(a->counts().own.sent == 1);
}

TEST_CASE("without multicast configured addresses are reached, each once") {
  UdpPortOptions options = on_this_machine();
  options.multicast = false;
  const auto b = opened(options), c = opened(options);
  const std::string to_b = "127.0.0.1:" + std::to_string(b->port());
  options.peers = {to_b, "127.0.0.1:" + std::to_string(c->port()), to_b};
  const auto a = opened(options);
  CHECK_FALSE(b->send(net::kEverybody, bytes_of("to nobody")));
  CHECK(b->counts().nowhere == 1);
  REQUIRE(a->send(net::kEverybody, bytes_of("hello")));
  CHECK(all_heard(*b, 1).size() == 1);
  const auto at_c = all_heard(*c, 1);
  REQUIRE(at_c.size() == 1);
  CHECK(c->send(at_c[0].from, bytes_of("hello too")));
  CHECK(all_heard(*a, 1).size() == 1);
}

TEST_CASE("the second robot of a machine takes a free port, unless it is to have that one") {
  const auto a = opened(on_this_machine());
  UdpPortOptions options = on_this_machine();
  options.port = a->port();
  const auto b = opened(options);
  CHECK(b->port() != a->port());
  CHECK(b->port() != 0);
  options.needs_port = true;
  const auto taken = UdpPort::open(options);
  REQUIRE_FALSE(taken);
  CHECK(taken.error().reason == Reason::no_capacity);
}

TEST_CASE("a flood at one socket does not silence the other") {
  const auto a = opened(on_this_machine()), b = opened(on_this_machine());
  const net::Address at_b = UdpPort::address_of(0x7F000001, b->port());
  for (int i = 0; i < 200; ++i) REQUIRE(a->send(at_b, bytes_of("noise")));
  REQUIRE(a->send(net::kEverybody, bytes_of("word")));
  for (int i = 0; i < 200; ++i) REQUIRE(a->send(at_b, bytes_of("noise")));
  const auto heard = all_heard(*b, 401);
  REQUIRE(heard.size() == 401);
  for (std::size_t i = 0; i < heard.size(); ++i) {
    if (heard[i].text == "word") CHECK(i < 70);
  }
}

TEST_CASE("waiting ends with the first datagram, or after its time") {
  const auto a = opened(on_this_machine()), b = opened(on_this_machine());
  CHECK_FALSE(b->wait(1'000'000));
  CHECK_FALSE(b->wait(-1));
  REQUIRE(a->send(net::kEverybody, bytes_of("1")));
  REQUIRE(a->send(net::kEverybody, bytes_of("2")));
  CHECK(b->wait(kPatience_ns));
  REQUIRE(b->receive());
  CHECK(b->wait(0));  // one of the batch is left
  REQUIRE(b->receive());
  CHECK_FALSE(b->wait(0));
}

TEST_CASE("options that cannot be are refused, each with a word") {
  const auto reason_of = [](const std::function<void(UdpPortOptions&)>& change) {
    UdpPortOptions options = on_this_machine();
    change(options);
    const auto port = UdpPort::open(options);
    REQUIRE_FALSE(port);
    CHECK(port.error().text.find("radio: ") == 0);
    return port.error().reason;
  };
  CHECK(reason_of([](auto& o) { o.group = "10.0.0.1"; }) == Reason::bad_usage);
  CHECK(reason_of([](auto& o) { o.group = "fleet"; }) == Reason::bad_usage);
  CHECK(reason_of([](auto& o) { o.group_port = 0; }) == Reason::bad_usage);
  CHECK(reason_of([](auto& o) { o.address = "any"; }) == Reason::bad_usage);
  CHECK(reason_of([](auto& o) { o.peers = {"robot1:7177"}; }) == Reason::bad_usage);
  CHECK(reason_of([](auto& o) { o.peers = {"239.1.2.3:7177"}; }) == Reason::bad_usage);
  CHECK(reason_of([](auto& o) { o.peers.assign(65, "10.0.0.1:7177"); }) == Reason::bad_usage);
}

TEST_CASE("addresses are told as people write them, and none is everybody's") {
  CHECK(UdpPort::text_of(UdpPort::address_of(0x0A000002, 4711)) == "10.0.0.2:4711");
  CHECK(UdpPort::text_of(net::kEverybody) == "everybody");
  CHECK(UdpPort::address_of(0, 0) != net::kEverybody);
  CHECK(UdpPort::endpoint_of(UdpPort::address_of(0xFFFFFFFF, 65535)) == hal::Ipv4Endpoint{0xFFFFFFFF, 65535});
}

TEST_CASE("a radio that was down at the start, or went and came back, is used again") {
  (void)test::in_own_network([] {
    const auto a = opened(on_this_machine()), b = opened(on_this_machine());
    const auto is_heard = [&] {
      (void)a->send(net::kEverybody, bytes_of("x"));
      (void)b->wait(20'000'000);
      return !all_heard(*b, 0).empty();
    };
    CHECK_FALSE(is_heard());
    CHECK(a->counts().nowhere == 1);
    for (int times = 0; times < 2; ++times) {
      REQUIRE(test::set_interface_up("lo", true));
      for (const auto* port : {&a, &b}) (*port)->refresh();
      CHECK(is_heard());
      REQUIRE(test::set_interface_up("lo", false));
      CHECK_FALSE(is_heard());
      for (const auto* port : {&a, &b}) (*port)->refresh();
      CHECK_FALSE(is_heard());
    }
    CHECK(a->counts().own.unreachable == 2);
    CHECK(a->counts().multicast.joined == 2);
  });
}
