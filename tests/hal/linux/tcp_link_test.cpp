// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/tcp_link.hpp"

#include <poll.h>

#include <array>
#include <catch2/catch.hpp>
#include <thread>
#include <vector>

using namespace g3d::hal;

namespace {

constexpr std::uint32_t kLoopback = 0x7F000001;

TcpLink accepted(TcpListener& listener) {
  pollfd wait{listener.fd(), POLLIN, 0};
  REQUIRE(::poll(&wait, 1, 10'000) == 1);
  Ipv4Endpoint from;
  auto link = listener.accept(from);
  REQUIRE(link);
  CHECK(from.ipv4 == kLoopback);
  return std::move(*link);
}

}  // namespace

TEST_CASE("bytes go both ways over a connection, and an end is read as one", "[threads]") {
  auto listener = TcpListener::open({kLoopback, 0});
  REQUIRE(listener.ok());
  CHECK(listener.value().endpoint().port != 0);
  Ipv4Endpoint nobody;
  CHECK_FALSE(listener.value().accept(nobody));
  auto here = TcpLink::connect(listener.value().endpoint(), 10'000);
  REQUIRE(here.ok());
  TcpLink there = accepted(listener.value());

  std::size_t count = 1;
  std::array<std::uint8_t, 4> few{};
  CHECK(there.receive(few, count) == TcpLink::Outcome::not_yet);
  CHECK(count == 0);

  std::vector<std::uint8_t> sent(3'000'000);
  for (std::size_t i = 0; i < sent.size(); ++i) sent[i] = static_cast<std::uint8_t>(i >> 8);
  bool is_sent = false;
  std::thread sender([&] { is_sent = here.value().send_all(sent, 10'000); });
  std::vector<std::uint8_t> got(sent.size());
  const bool is_got = there.receive_all(got, 10'000);
  sender.join();
  CHECK(is_sent);
  CHECK(is_got);
  CHECK(got == sent);

  here.value().say_no_more();
  CHECK_FALSE(there.receive_all(few, 10'000));
  CHECK(there.send_all(std::span(sent).first(4), 10'000));
  CHECK(here.value().receive_all(few, 10'000));
}

TEST_CASE("a peer that is gone or says nothing costs no signal and no more time than was said", "[threads]") {
  auto listener = TcpListener::open({kLoopback, 0});
  REQUIRE(listener.ok());
  auto here = TcpLink::connect(listener.value().endpoint(), 10'000);
  REQUIRE(here.ok());
  TcpLink there = accepted(listener.value());
  std::array<std::uint8_t, 4> few{};
  CHECK_FALSE(here.value().receive_all(few, 20));
  const std::vector<std::uint8_t> much(50'000'000);
  CHECK_FALSE(here.value().send_all(much, 20));  // nobody reads
  there.close();
  CHECK_FALSE(there.is_open());
  CHECK_FALSE(here.value().send_all(much, 10'000));
  CHECK_FALSE(here.value().send_all(much, 10'000));
}

TEST_CASE("what cannot be reached or had says why") {
  std::uint16_t port = 0;
  {
    auto listener = TcpListener::open({kLoopback, 0});
    REQUIRE(listener.ok());
    port = listener.value().endpoint().port;
    const auto second = TcpListener::open({kLoopback, port});
    REQUIRE_FALSE(second.ok());
    CHECK(second.error().reason == Reason::no_capacity);
  }
  const auto refused = TcpLink::connect({kLoopback, port}, 10'000);
  REQUIRE_FALSE(refused.ok());
  CHECK(refused.error().reason == Reason::not_found);
  CHECK_THAT(refused.error().text, Catch::Contains("127.0.0.1:") && Catch::Contains("nothing listens"));
  CHECK(TcpListener::open({0xC0000207, 0}).error().reason == Reason::not_found);
}
