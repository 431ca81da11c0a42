// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/can_link.hpp"

#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>

#include <catch2/catch.hpp>
#include <map>
#include <span>

#include "tests/support/own_network.hpp"

using namespace g3d;
using namespace g3d::hal;

namespace {

using Bytes = std::span<const std::uint8_t>;

/// What is in a row of attributes, each checked to lie within it.
std::map<int, Bytes> attributes_of(Bytes bytes) {
  std::map<int, Bytes> found;
  while (bytes.size() >= sizeof(nlattr)) {
    nlattr header{};
    std::memcpy(&header, bytes.data(), sizeof header);
    REQUIRE(header.nla_len >= sizeof header);
    REQUIRE(header.nla_len <= bytes.size());
    found[header.nla_type] = bytes.subspan(sizeof header, header.nla_len - sizeof header);
    bytes = bytes.subspan(std::min<std::size_t>(NLA_ALIGN(header.nla_len), bytes.size()));
  }
  CHECK(bytes.empty());
  return found;
}
template <typename Value>
Value value_of(Bytes bytes) {
  Value value{};
  REQUIRE(bytes.size() == sizeof value);
  std::memcpy(&value, bytes.data(), sizeof value);
  return value;
}

}  // namespace

TEST_CASE("A request for a bit rate is what rtnetlink wants", "[can]") {
  CanLinkRequest request;
  request.interface = "can0";
  request.index = 3;
  request.kind = "can";
  request.bitrate = 500'000;
  request.restart_ms = 0;
  const auto message = encode_link_request(request, 77);
  nlmsghdr header{};
  ifinfomsg info{};
  std::memcpy(&header, message.data(), sizeof header);
  std::memcpy(&info, message.data() + NLMSG_HDRLEN, sizeof info);
  CHECK(header.nlmsg_len == message.size());
  CHECK(header.nlmsg_type == RTM_NEWLINK);
  CHECK(header.nlmsg_flags == (NLM_F_REQUEST | NLM_F_ACK));
  CHECK(header.nlmsg_seq == 77);
  CHECK(info.ifi_index == 3);
  CHECK(info.ifi_change == 0);
  const auto top = attributes_of(Bytes(message).subspan(NLMSG_LENGTH(sizeof info)));
  CHECK(top.count(IFLA_IFNAME) == 0);
  const auto link = attributes_of(top.at(IFLA_LINKINFO));
  CHECK(std::string(reinterpret_cast<const char*>(link.at(IFLA_INFO_KIND).data())) == "can");
  const auto data = attributes_of(link.at(IFLA_INFO_DATA));
  CHECK(value_of<can_bittiming>(data.at(IFLA_CAN_BITTIMING)).bitrate == 500'000);
  CHECK(value_of<std::uint32_t>(data.at(IFLA_CAN_RESTART_MS)) == 0);
  CHECK(data.count(IFLA_CAN_RESTART) == 0);
}

TEST_CASE("A virtual interface is made by name", "[can]") {
  CanLinkRequest request;
  request.interface = "vcan0";
  request.creates = true;
  request.kind = "vcan";
  request.is_up = true;
  const auto message = encode_link_request(request, 1);
  nlmsghdr header{};
  ifinfomsg info{};
  std::memcpy(&header, message.data(), sizeof header);
  std::memcpy(&info, message.data() + NLMSG_HDRLEN, sizeof info);
  CHECK(header.nlmsg_flags == (NLM_F_REQUEST | NLM_F_ACK | NLM_F_CREATE | NLM_F_EXCL));
  CHECK(info.ifi_flags == IFF_UP);
  const auto top = attributes_of(Bytes(message).subspan(NLMSG_LENGTH(sizeof info)));
  CHECK(std::string(reinterpret_cast<const char*>(top.at(IFLA_IFNAME).data())) == "vcan0");
}

TEST_CASE("A link goes down and up through netlink", "[can][threads]") {
  (void)test::in_own_network([] {
    const auto is_up = [] {
      const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
      ifreq request{};
      std::strncpy(request.ifr_name, "lo", sizeof request.ifr_name - 1);
      const bool read = ::ioctl(fd, SIOCGIFFLAGS, &request) == 0;
      ::close(fd);
      return read && (request.ifr_flags & IFF_UP) != 0;
    };
    REQUIRE_FALSE(is_up());
    CHECK_FALSE(link_is_up("lo"));
    CHECK(bring_can_up("lo", 0).ok());
    CHECK(is_up());
    CHECK(link_is_up("lo"));
    CHECK_FALSE(link_is_up("nocan7"));
    CanLinkRequest down;
    down.interface = "lo";
    down.is_up = false;
    CHECK(ask_for_link(down).ok());
    CHECK_FALSE(is_up());
    // No CAN controller: refused, not believed.
    const auto rate = bring_can_up("lo", 500'000);
    CHECK_FALSE(rate.ok());
  });
}

TEST_CASE("Interfaces that there are not have errors with a remedy", "[can]") {
  const auto missing = bring_can_up("nocan7", 0);
  REQUIRE_FALSE(missing.ok());
  CHECK(missing.error().reason == Reason::not_found);
  CHECK(bring_can_up("", 0).error().reason == Reason::bad_usage);
  CHECK(make_virtual_can("a name that is too long").error().reason == Reason::bad_usage);
}
