// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/udp_socket.hpp"

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <vector>

#include "hal/linux/multicast_group.hpp"
#include "tests/support/own_network.hpp"

using namespace g3d;
using hal::Reason;
using hal::UdpSocket;
using hal::UdpSocketOptions;

namespace {

constexpr std::uint32_t kHere_ipv4 = 0x7F000001;
constexpr std::uint32_t kGroup_ipv4 = 0xEFFF474D;
using Datagram = std::vector<std::uint8_t>;

UdpSocketOptions here(std::uint16_t port = 0) {
  UdpSocketOptions options;
  options.bind = {kHere_ipv4, port};
  return options;
}

std::unique_ptr<UdpSocket> opened(const UdpSocketOptions& options) {
  auto socket = UdpSocket::open(options);
  if (!socket) FAIL(socket.error().text);
  return std::move(socket).value();
}

/// One that was sent: on a busy machine it may take its time.
std::optional<UdpSocket::Received> next(UdpSocket& socket) {
  pollfd wait{socket.fd(), POLLIN, 0};
  if (socket.left_in_batch() == 0) (void)::poll(&wait, 1, 2000);
  return socket.receive();
}

Datagram numbered(std::size_t bytes, std::size_t number) {
  Datagram datagram(bytes, static_cast<std::uint8_t>(number));
  return datagram;
}

}  // namespace

TEST_CASE("datagrams come as they were sent, with where they came from") {
  const auto a = opened(here()), b = opened(here());
  CHECK_FALSE(b->receive());
  for (std::size_t i = 0; i < 100; ++i) REQUIRE(a->send(b->bound(), numbered(i * 12, i)));
  for (std::size_t i = 0; i < 100; ++i) {
    const auto received = next(*b);
    REQUIRE(received);
    CHECK(received->from == a->bound());
    const Datagram wanted = numbered(i * 12, i);
    CHECK(std::equal(received->datagram.begin(), received->datagram.end(), wanted.begin(), wanted.end()));
  }
  CHECK_FALSE(b->receive());
  CHECK(a->counts().sent == 100);
  CHECK(b->counts().received == 100);
  CHECK(a->counts().sent_bytes == b->counts().received_bytes);
  // And back.
  REQUIRE(b->send(a->bound(), numbered(5, 1)));
  CHECK(next(*a));
}

TEST_CASE("a datagram that is too long is dropped whole and counted, and those around it come") {
  const auto a = opened(here()), b = opened(here());
  for (const std::size_t bytes : {1200, 1201, 0, 9000, 1200}) REQUIRE(a->send(b->bound(), numbered(bytes, 7)));
  std::vector<std::size_t> sizes;
  while (sizes.size() < 3) {
    const auto received = next(*b);
    REQUIRE(received);
    sizes.push_back(received->datagram.size());
  }
  CHECK_FALSE(b->receive());
  CHECK(sizes == std::vector<std::size_t>{1200, 0, 1200});
  CHECK(b->counts().too_long == 2);
  CHECK(b->counts().received == 3);
}

TEST_CASE("a flood of what is too long does not hide a datagram behind it") {
  UdpSocketOptions large = here();
  large.receive_buffer_bytes = 4 << 20;
  const auto a = opened(here()), b = opened(large);
  for (std::size_t i = 0; i < 100; ++i) REQUIRE(a->send(b->bound(), numbered(1300, i)));
  REQUIRE(a->send(b->bound(), numbered(10, 1)));
  pollfd wait{b->fd(), POLLIN, 0};
  REQUIRE(::poll(&wait, 1, 2000) == 1);
  const auto received = b->receive();
  REQUIRE(received);
  CHECK(received->datagram.size() == 10);
  CHECK(b->counts().too_long == 100);
}

TEST_CASE("what the kernel had to drop is counted") {
  UdpSocketOptions small = here();
  small.receive_buffer_bytes = 8192;
  const auto a = opened(here()), b = opened(small);
  for (std::size_t i = 0; i < 200; ++i) REQUIRE(a->send(b->bound(), numbered(1000, i)));
  std::uint64_t came = 0;
  pollfd wait{b->fd(), POLLIN, 0};
  while (::poll(&wait, 1, 20) > 0) {
    while (b->receive()) ++came;
  }
  REQUIRE(came < 200);
  REQUIRE(a->send(b->bound(), numbered(1, 1)));
  REQUIRE(next(*b));
  CHECK(b->counts().overflowed == 200 - came);
}

TEST_CASE("a buffer as large as was asked for is given, as far as the system lets us") {
  UdpSocketOptions small = here(), large = here();
  small.receive_buffer_bytes = 16384;
  large.receive_buffer_bytes = 1 << 20;
  CHECK(opened(large)->receive_buffer_bytes() > 4 * opened(small)->receive_buffer_bytes());
}

TEST_CASE("a port has one owner, unless all share it") {
  const auto a = opened(here());
  const auto taken = UdpSocket::open(here(a->bound().port));
  REQUIRE_FALSE(taken);
  CHECK(taken.error().reason == Reason::no_capacity);
  CHECK(taken.error().text.find("give another port") != std::string::npos);
  UdpSocketOptions sharing = here(a->bound().port);
  sharing.shares_port = true;
  CHECK_FALSE(UdpSocket::open(sharing));
  sharing.bind.port = 0;
  const auto first = opened(sharing);
  sharing.bind = first->bound();
  CHECK(UdpSocket::open(sharing));
}

TEST_CASE("an address that is not ours, and sizes that cannot be, are refused with a word") {
  UdpSocketOptions options = here();
  options.bind.ipv4 = 0xC0000201;  // 192.0.2.1, of no machine
  const auto foreign = UdpSocket::open(options);
  REQUIRE_FALSE(foreign);
  CHECK(foreign.error().reason == Reason::not_found);
  for (const std::size_t bytes : {0, 70000}) {
    options = here();
    options.most_datagram_bytes = bytes;
    const auto lying = UdpSocket::open(options);
    REQUIRE_FALSE(lying);
    CHECK(lying.error().reason == Reason::bad_usage);
  }
}

TEST_CASE("what is sent to a group reaches every program of the machine that listens, the sender's too") {
  UdpSocketOptions options;
  options.bind = {kGroup_ipv4, 0};
  options.shares_port = true;
  const auto a = opened(options);
  options.bind = a->bound();
  const auto b = opened(options);
  const auto sender = opened({});
  hal::MulticastGroup at_a(a->fd(), kGroup_ipv4, "lo"), at_b(b->fd(), kGroup_ipv4, "lo");
  at_a.refresh();
  REQUIRE(at_a.joined().size() == 1);
  REQUIRE(sender->send(a->bound(), numbered(50, 3), at_a.joined()[0]));
  CHECK(next(*a));
  CHECK_FALSE(b->receive());  // has not joined
  at_b.refresh();
  REQUIRE(sender->send(a->bound(), numbered(50, 3), at_a.joined()[0]));
  for (const auto* socket : {&a, &b}) {
    const auto received = next(**socket);
    REQUIRE(received);
    CHECK(received->from == hal::Ipv4Endpoint{kHere_ipv4, sender->bound().port});
    CHECK_FALSE((*socket)->receive());
  }
  CHECK_FALSE(sender->receive());
}

TEST_CASE("datagrams that cannot leave are counted by reason") {
  (void)test::in_own_network([] {
    const auto socket = opened({});
    CHECK_FALSE(socket->send({kHere_ipv4, 7177}, numbered(1, 1)));
    CHECK_FALSE(socket->send({0x0A000002, 7177}, numbered(1, 1)));
    CHECK_FALSE(socket->send({kGroup_ipv4, 7176}, numbered(1, 1), hal::Leaving{77, 0}));
    CHECK(socket->counts().unreachable == 3);
    REQUIRE(test::set_interface_up("lo", true));
    CHECK(socket->send({kHere_ipv4, 7177}, numbered(1, 1)));
    CHECK_FALSE(socket->send({kHere_ipv4, 7177}, Datagram(66000)));
    CHECK(socket->counts().not_sent == 1);
    CHECK(socket->counts().sent == 1);
  });
}
