// SPDX-License-Identifier: Apache-2.0
// Machines at one access point, each a network namespace of this one: a bridge, and for every machine an interface
// `radio` with an address of its own, 10.77.0.1 and on, that may go down. For the body of in_own_network(): what the
// calling thread opens or starts belongs to the machine that it has entered last. Nothing of it is left afterwards.
#pragma once

#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <string>
#include <vector>

#include "tests/support/own_network.hpp"

namespace g3d::test {

/// Whether a shell command does what it says.
inline bool does(const std::string& command) { return std::system((command + " >/dev/null 2>&1").c_str()) == 0; }

/// A network that the calling thread may enter; it lasts as long as this.
class Network {
 public:
  Network() {
    REQUIRE(::unshare(CLONE_NEWNET) == 0);
    fd_ = ::open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC);
    REQUIRE(fd_ >= 0);
  }
  ~Network() { ::close(fd_); }
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;
  void enter() const { REQUIRE(::setns(fd_, CLONE_NEWNET) == 0); }
  [[nodiscard]] std::string path() const { return fmt::format("/proc/{}/fd/{}", ::getpid(), fd_); }

 private:
  int fd_ = -1;
};

class AccessPoint {
 public:
  explicit AccessPoint(std::size_t machines) : machines_(machines) {}
  /// False: this system does not permit it, which is said.
  [[nodiscard]] bool build() const {
    if (!does("ip -V")) {
      WARN("skipped: there is no `ip` here (Debian: iproute2)");
      return false;
    }
    bridge_.enter();
    if (!does("ip link add ap type bridge mcast_snooping 0 && ip link set ap up")) {
      WARN("skipped: this system has no bridges");
      return false;
    }
    for (std::size_t i = 0; i < machines_.size(); ++i) {
      bridge_.enter();
      if (!does(fmt::format("ip link add to{0} type veth peer name radio netns {1} && ip link set to{0} master ap up",
                            i, machines_[i].path()))) {
        WARN("skipped: this system has no veth pairs");
        return false;
      }
      enter(i);
      const std::string address = fmt::format("10.77.0.{}/24", i + 1);
      REQUIRE(does("ip link set lo up && ip addr add " + address + " dev radio && ip link set radio up"));
    }
    return true;
  }
  void enter(std::size_t i) const { machines_[i].enter(); }
  void set_radio_up(std::size_t i, bool is_up) const {
    enter(i);
    REQUIRE(set_interface_up("radio", is_up));
  }

 private:
  std::vector<Network> machines_;
  Network bridge_;
};

}  // namespace g3d::test
