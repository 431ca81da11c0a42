// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/network_card.hpp"

#include <errno.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <net/route.h>
#include <netinet/in.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>

#include "hal/image/atomic_file.hpp"

namespace g3d::hal::boot {
namespace {

/// A socket for ioctl alone.
class AskingSocket {
 public:
  AskingSocket() : fd_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {}
  ~AskingSocket() {
    if (fd_ >= 0) ::close(fd_);
  }
  AskingSocket(const AskingSocket&) = delete;
  AskingSocket& operator=(const AskingSocket&) = delete;
  template <typename Request>
  [[nodiscard]] bool ask(unsigned long what, Request& request) const {
    return ::ioctl(fd_, what, &request) == 0;
  }

 private:
  int fd_;
};

ifreq request_for(const std::string& card) {
  ifreq request{};
  ::memcpy(request.ifr_name, card.data(), std::min(card.size(), sizeof request.ifr_name - 1));
  return request;
}

void put_ipv4_address(sockaddr& at, std::uint32_t ipv4) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(ipv4);
  ::memcpy(&at, &address, sizeof at);
}

}  // namespace

std::vector<std::string> ethernet_cards(const std::string& net_folder) {
  std::vector<std::string> cards;
  std::error_code code;
  for (std::filesystem::directory_iterator entry(net_folder, code), end; !code && entry != end; entry.increment(code)) {
    std::ifstream file(entry->path() / "type");
    int type = -1;
    file >> type;
    if (type == ARPHRD_ETHER) cards.push_back(entry->path().filename().string());
  }
  std::sort(cards.begin(), cards.end());
  return cards;
}

Result<void> switch_on(const std::string& card) {
  const AskingSocket socket;
  ifreq request = request_for(card);
  if (!socket.ask(SIOCGIFFLAGS, request)) return system_error(card, "no such network card", errno);
  request.ifr_flags = static_cast<short>(request.ifr_flags | IFF_UP);
  if (!socket.ask(SIOCSIFFLAGS, request)) return system_error(card, "cannot be switched on", errno);
  return {};
}

Result<void> set_address(const std::string& card, std::uint32_t ipv4, int prefix_bits) {
  const AskingSocket socket;
  ifreq request = request_for(card);
  put_ipv4_address(request.ifr_addr, ipv4);
  if (!socket.ask(SIOCSIFADDR, request)) return system_error(card, "takes no address", errno);
  put_ipv4_address(request.ifr_netmask, ~0U << (32 - prefix_bits));
  if (!socket.ask(SIOCSIFNETMASK, request)) return system_error(card, "takes no netmask", errno);
  return {};
}

Result<void> set_gateway(std::uint32_t ipv4) {
  const AskingSocket socket;
  rtentry route{};
  put_ipv4_address(route.rt_dst, 0);
  put_ipv4_address(route.rt_genmask, 0);
  put_ipv4_address(route.rt_gateway, ipv4);
  route.rt_flags = RTF_UP | RTF_GATEWAY;
  if (!socket.ask(SIOCADDRT, route) && errno != EEXIST) return system_error("gateway", "cannot be set", errno);
  return {};
}

std::optional<MacAddress> mac_of(const std::string& card) {
  const AskingSocket socket;
  ifreq request = request_for(card);
  if (!socket.ask(SIOCGIFHWADDR, request) || request.ifr_hwaddr.sa_family != ARPHRD_ETHER) return std::nullopt;
  MacAddress mac{};
  ::memcpy(mac.data(), request.ifr_hwaddr.sa_data, mac.size());
  return mac;
}

int index_of(const std::string& card) { return static_cast<int>(::if_nametoindex(card.c_str())); }

Result<void> make_virtual_can(const std::string& name) {
  if (index_of(name) != 0) return {};
  // RTM_NEWLINK with IFLA_IFNAME and IFLA_LINKINFO { IFLA_INFO_KIND "vcan" }
  struct {
    nlmsghdr header{};
    ifinfomsg link{};
    std::array<char, 64> attributes{};
  } message;
  static_assert(sizeof message == NLMSG_LENGTH(sizeof(ifinfomsg)) + 64);
  std::size_t size = 0;
  const auto put = [&](std::uint16_t type, const void* data, std::size_t bytes) {
    const rtattr head{static_cast<std::uint16_t>(RTA_LENGTH(bytes)), type};
    ::memcpy(message.attributes.data() + size, &head, sizeof head);
    ::memcpy(message.attributes.data() + size + sizeof head, data, bytes);
    size += RTA_SPACE(bytes);
  };
  const std::string short_name = name.substr(0, IFNAMSIZ - 1);
  put(IFLA_IFNAME, short_name.c_str(), short_name.size() + 1);
  const std::size_t info = size;
  put(IFLA_LINKINFO, "", 0);
  put(IFLA_INFO_KIND, "vcan", 5);
  const auto info_bytes = static_cast<std::uint16_t>(size - info);
  ::memcpy(message.attributes.data() + info, &info_bytes, sizeof info_bytes);
  message.header.nlmsg_len = static_cast<std::uint32_t>(NLMSG_LENGTH(sizeof(ifinfomsg)) + size);
  message.header.nlmsg_type = RTM_NEWLINK;
  message.header.nlmsg_flags = NLM_F_REQUEST | NLM_F_CREATE | NLM_F_EXCL | NLM_F_ACK;
  const int fd = ::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
  struct {
    nlmsghdr header{};
    nlmsgerr error{};
    std::array<char, 256> more{};
  } answer;
  const bool is_answered =
      fd >= 0 && ::send(fd, &message, message.header.nlmsg_len, 0) > 0 &&
      ::recv(fd, &answer, sizeof answer, 0) >= static_cast<ssize_t>(NLMSG_LENGTH(sizeof(nlmsgerr)));
  const int problem = is_answered ? -answer.error.error : errno;
  if (fd >= 0) ::close(fd);
  if (!is_answered || problem != 0) return system_error(name, "cannot be made", problem);
  return {};
}

}  // namespace g3d::hal::boot
