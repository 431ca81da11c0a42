// SPDX-License-Identifier: Apache-2.0
// What anybody on the same network may send to a robot that has just been switched on: questions of multicast DNS, ARP.
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "hal/boot/link_local.hpp"
#include "hal/boot/mdns_answer.hpp"
#include "hal/boot/robot_health.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace g3d::hal::boot;
  std::array<std::uint8_t, 96> out{};
  for (const bool from_mdns_port : {false, true}) {
    const MdnsAnswer answer = answer_mdns({data, size}, from_mdns_port, {"robot1", 0x0A000007}, out);
    if (answer.size_bytes > out.size()) std::abort();
  }
  LinkLocal local({2, 0, 0, 0, 0, 1}, 0);
  (void)local.on_time(local.next_ns());
  if (const auto arp = decode_arp({data, size})) (void)local.on_arp(*arp, 1);
  if (local.address()) std::abort();  // not before it has asked three times
  (void)parse_notice({reinterpret_cast<const char*>(data), size});
  return 0;
}
