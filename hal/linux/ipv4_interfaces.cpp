// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/ipv4_interfaces.hpp"

#include <net/if.h>
#include <netinet/in.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <cstring>

namespace g3d::hal {

Ipv4Interfaces list_ipv4_interfaces(int fd) {
  Ipv4Interfaces found;
  // One row for each address; an interface may have several.
  std::array<ifreq, 4 * Ipv4Interfaces::kMost> rows{};
  ifconf request{};
  request.ifc_len = sizeof rows;
  request.ifc_req = rows.data();
  if (::ioctl(fd, SIOCGIFCONF, &request) != 0) return found;
  const std::size_t row_count = static_cast<std::size_t>(request.ifc_len) / sizeof(ifreq);
  for (std::size_t i = 0; i < row_count && found.count < found.list.size(); ++i) {
    ifreq row = rows[i];
    Ipv4Interface one;
    std::memcpy(one.name.data(), row.ifr_name, one.name.size() - 1);
    // A second address may come under a label such as eth0:1.
    if (char* const label = std::find(one.name.begin(), one.name.end(), ':'); label != one.name.end()) *label = '\0';
    sockaddr_in address{};
    std::memcpy(&address, &row.ifr_addr, sizeof address);
    one.ipv4 = ntohl(address.sin_addr.s_addr);
    // Between these questions it may vanish.
    if (::ioctl(fd, SIOCGIFINDEX, &row) != 0) continue;
    one.index = row.ifr_ifindex;
    if (::ioctl(fd, SIOCGIFFLAGS, &row) != 0) continue;
    const auto flags = static_cast<unsigned>(static_cast<unsigned short>(row.ifr_flags));
    one.is_running = (flags & IFF_UP) != 0 && (flags & IFF_RUNNING) != 0;
    one.has_multicast = (flags & IFF_MULTICAST) != 0;
    one.is_loopback = (flags & IFF_LOOPBACK) != 0;
    const auto known = found.all();
    if (std::any_of(known.begin(), known.end(), [&](const Ipv4Interface& k) { return k.index == one.index; })) continue;
    found.list[found.count++] = one;
  }
  return found;
}

}  // namespace g3d::hal
