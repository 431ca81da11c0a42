// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/can_link.hpp"

#include <fmt/format.h>
#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <iterator>
#include <span>

namespace g3d::hal {
namespace {

/// Attributes of netlink: aligned to four bytes, and some within others.
class LinkMessage {
 public:
  LinkMessage() : bytes_(NLMSG_LENGTH(sizeof(ifinfomsg))) {}

  void put(std::uint16_t type, std::span<const std::uint8_t> value) {
    const std::size_t at = begin(type);
    bytes_.insert(bytes_.end(), value.begin(), value.end());
    end(at);
  }
  template <typename Value>
  void put_value(std::uint16_t type, const Value& value) {
    put(type, {reinterpret_cast<const std::uint8_t*>(&value), sizeof value});
  }
  void put_text(std::uint16_t type, const std::string& text) {
    put(type, {reinterpret_cast<const std::uint8_t*>(text.c_str()), text.size() + 1});
  }
  [[nodiscard]] std::size_t begin(std::uint16_t type) {
    const std::size_t at = bytes_.size();
    const nlattr header{0, type};
    bytes_.resize(at + NLA_HDRLEN);
    std::memcpy(bytes_.data() + at, &header, sizeof header);
    return at;
  }
  void end(std::size_t at) {
    const auto length = static_cast<std::uint16_t>(bytes_.size() - at);
    std::memcpy(bytes_.data() + at, &length, sizeof length);
    bytes_.resize(NLMSG_ALIGN(bytes_.size()));
  }
  std::vector<std::uint8_t> take(nlmsghdr header, const ifinfomsg& info) {
    header.nlmsg_len = static_cast<std::uint32_t>(bytes_.size());
    std::memcpy(bytes_.data(), &header, sizeof header);
    std::memcpy(bytes_.data() + NLMSG_HDRLEN, &info, sizeof info);
    return std::move(bytes_);
  }

 private:
  std::vector<std::uint8_t> bytes_;
};

Error link_error(const std::string& interface, int error) {
  const auto say = [&](Reason reason, const char* remedy) {
    return Error{reason, fmt::format("{}: {}; {}", interface, std::strerror(error), remedy)};
  };
  switch (error) {
    case ENODEV:
      return say(Reason::not_found, "no such interface: load its driver, or set can.interface in the board file");
    case EPERM:
    case EACCES:
      return say(Reason::no_permission, "run it with CAP_NET_ADMIN, or bring the link up before");
    case EOPNOTSUPP:
      return say(Reason::unsupported, "this kernel or interface cannot do that: load the module can_dev or vcan");
    case EINVAL:
    case ERANGE:
    case EDOM:
      return say(Reason::unsupported, "its controller refuses that: see can.bitrate in the board file");
    default:
      return say(Reason::io_error, "see dmesg for what the CAN driver says");
  }
}

/// 0 or an errno.
int converse(std::span<const std::uint8_t> message, std::uint32_t sequence) {
  const int fd = ::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
  if (fd < 0) return errno;
  const timeval patience{2, 0};
  (void)::setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  int error = EIO;
  if (::send(fd, message.data(), message.size(), 0) != static_cast<ssize_t>(message.size())) {
    error = errno;
  } else {
    alignas(nlmsghdr) std::array<char, 4096> answer{};
    const ssize_t count = ::recv(fd, answer.data(), answer.size(), 0);
    nlmsghdr header{};
    nlmsgerr said{};
    if (count < 0) {
      error = errno;
    } else if (static_cast<std::size_t>(count) >= NLMSG_LENGTH(sizeof said)) {
      std::memcpy(&header, answer.data(), sizeof header);
      std::memcpy(&said, answer.data() + NLMSG_HDRLEN, sizeof said);
      if (header.nlmsg_type == NLMSG_ERROR && header.nlmsg_seq == sequence) error = -said.error;
    }
  }
  ::close(fd);
  return error;
}

bool is_interface_name(const std::string& interface) { return !interface.empty() && interface.size() < IFNAMSIZ; }

}  // namespace

std::vector<std::uint8_t> encode_link_request(const CanLinkRequest& request, std::uint32_t sequence) {
  LinkMessage message;
  if (request.index == 0) message.put_text(IFLA_IFNAME, request.interface);
  if (!request.kind.empty()) {
    const std::size_t link = message.begin(IFLA_LINKINFO);
    message.put_text(IFLA_INFO_KIND, request.kind);
    const std::size_t data = message.begin(IFLA_INFO_DATA);
    if (request.bitrate) {
      can_bittiming timing{};
      timing.bitrate = *request.bitrate;  // the rest the kernel works out
      message.put_value(IFLA_CAN_BITTIMING, timing);
    }
    if (request.restart_ms) message.put_value(IFLA_CAN_RESTART_MS, *request.restart_ms);
    if (request.restarts) message.put_value(IFLA_CAN_RESTART, std::uint32_t{1});
    message.end(data);
    message.end(link);
  }
  nlmsghdr header{};
  header.nlmsg_type = RTM_NEWLINK;
  header.nlmsg_flags = NLM_F_REQUEST | NLM_F_ACK;
  if (request.creates) header.nlmsg_flags |= NLM_F_CREATE | NLM_F_EXCL;
  header.nlmsg_seq = sequence;
  ifinfomsg info{};
  info.ifi_family = AF_UNSPEC;
  info.ifi_index = request.index;
  if (request.is_up) {
    info.ifi_change = IFF_UP;
    info.ifi_flags = *request.is_up ? unsigned{IFF_UP} : 0U;
  }
  return message.take(header, info);
}

Result<void> ask_for_link(const CanLinkRequest& request) {
  if (!is_interface_name(request.interface)) {
    return Error{Reason::bad_usage,
                 fmt::format("'{}': interfaces have names of 1 to 15 characters", request.interface)};
  }
  CanLinkRequest known = request;
  if (!known.creates) {
    known.index = static_cast<int>(::if_nametoindex(known.interface.c_str()));
    if (known.index == 0) return link_error(known.interface, ENODEV);
  }
  constexpr std::uint32_t kSequence = 1;
  const int error = converse(encode_link_request(known, kSequence), kSequence);
  if (error != 0) return link_error(known.interface, error);
  return {};
}

Result<void> bring_can_up(const std::string& interface, std::uint32_t bitrate) {
  CanLinkRequest request;
  request.interface = interface;
  if (bitrate > 0) {
    request.is_up = false;
    if (auto down = ask_for_link(request); !down) return down;
    request.is_up = {};
    request.kind = "can";
    request.bitrate = bitrate;
    request.restart_ms = 0;
    if (auto set = ask_for_link(request); !set) return set;
    request = {};
    request.interface = interface;
  }
  request.is_up = true;
  return ask_for_link(request);
}

bool link_is_up(const std::string& interface) {
  if (!is_interface_name(interface)) return false;
  const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ifreq request{};
  std::copy(interface.begin(), interface.end(), std::begin(request.ifr_name));
  const bool is_up = ::ioctl(fd, SIOCGIFFLAGS, &request) == 0 && (request.ifr_flags & IFF_UP) != 0;
  if (fd >= 0) ::close(fd);
  return is_up;
}

Result<void> restart_can(const std::string& interface) {
  CanLinkRequest request;
  request.interface = interface;
  request.kind = "can";
  request.restarts = true;
  if (const auto restarted = ask_for_link(request); restarted) return {};
  // A driver that cannot, or a kernel that is at it by itself: down and up again does the same.
  request = {};
  request.interface = interface;
  request.is_up = false;
  if (auto down = ask_for_link(request); !down) return down;
  request.is_up = true;
  return ask_for_link(request);
}

Result<void> make_virtual_can(const std::string& interface) {
  CanLinkRequest request;
  request.interface = interface;
  if (::if_nametoindex(interface.c_str()) == 0) {
    request.creates = true;
    request.kind = "vcan";
    if (auto made = ask_for_link(request); !made) return made;
  }
  return bring_can_up(interface, 0);
}

}  // namespace g3d::hal
