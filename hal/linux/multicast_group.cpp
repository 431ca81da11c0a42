// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/multicast_group.hpp"

#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace g3d::hal {

MulticastGroup::MulticastGroup(int fd, std::uint32_t group_ipv4, std::string interface)
    : fd_(fd), group_ipv4_(group_ipv4), interface_(std::move(interface)) {}

bool MulticastGroup::is_wanted(const Ipv4Interface& one, bool has_other) const {
  if (!one.is_running) return false;
  if (!interface_.empty()) return one.text() == interface_;
  return one.is_loopback ? !has_other : one.has_multicast;
}

bool MulticastGroup::change(int option, int index) const {
  ip_mreqn request{};
  request.imr_multiaddr.s_addr = htonl(group_ipv4_);
  request.imr_ifindex = index;
  return ::setsockopt(fd_, IPPROTO_IP, option, &request, sizeof request) == 0;
}

void MulticastGroup::refresh() {
  const Ipv4Interfaces now = list_ipv4_interfaces(fd_);
  const auto present = now.all();
  const bool has_other = std::any_of(present.begin(), present.end(), [](const Ipv4Interface& one) {
    return one.is_running && one.has_multicast && !one.is_loopback;
  });
  const auto find_wanted = [&](int index) {
    return std::find_if(present.begin(), present.end(),
                        [&](const Ipv4Interface& one) { return one.index == index && is_wanted(one, has_other); });
  };
  for (std::size_t i = 0; i < joined_count_;) {
    if (const auto here = find_wanted(joined_[i].interface_index); here != present.end()) {
      // It may have got another address meanwhile.
      joined_[i++].source_ipv4 = here->ipv4;
      continue;
    }
    // Of a device that is gone the kernel may have nothing left to leave.
    (void)change(IP_DROP_MEMBERSHIP, joined_[i].interface_index);
    joined_[i] = joined_[--joined_count_];
    ++counts_.left;
  }
  for (const Ipv4Interface& one : present) {
    const auto is_this = [&](const Leaving& known) { return known.interface_index == one.index; };
    const auto known = joined();
    if (!is_wanted(one, has_other) || known.size() == joined_.size() ||
        std::any_of(known.begin(), known.end(), is_this)) {
      continue;
    }
    // EADDRINUSE: this socket is a member there already.
    if (!change(IP_ADD_MEMBERSHIP, one.index) && errno != EADDRINUSE) {
      ++counts_.refused;
      continue;
    }
    joined_[joined_count_++] = {one.index, one.ipv4};
    ++counts_.joined;
  }
}

}  // namespace g3d::hal
