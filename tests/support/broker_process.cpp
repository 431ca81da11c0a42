// SPDX-License-Identifier: Apache-2.0
#include "tests/support/broker_process.hpp"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <stdexcept>
#include <thread>

#include "hal/mqtt/mqtt_client.hpp"

namespace g3d::test {
namespace {

constexpr const char* kMosquitto = "/usr/sbin/mosquitto";

sockaddr_in broker_address(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

/// One that nobody listens at just now.
std::uint16_t free_port() {
  const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address = broker_address(0);
  socklen_t size = sizeof address;
  const bool is_bound = ::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
                        ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) == 0;
  ::close(fd);
  if (!is_bound) throw std::runtime_error("no free port on the loopback interface");
  return ntohs(address.sin_port);
}

bool takes_connections(std::uint16_t port) {
  const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_in address = broker_address(port);
  const bool is_taken = ::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  ::close(fd);
  return is_taken;
}

}  // namespace

std::string BrokerProcess::what_is_missing() {
  if (!hal::MqttClient::is_built_in()) return "built without libmosquitto: scripts/static_libs builds it";
  if (::access(kMosquitto, X_OK) != 0) return std::string("no ") + kMosquitto + " here: scripts/setup installs it";
  return {};
}

BrokerProcess::BrokerProcess(const std::string& extra) : port_(free_port()) {
  // As root it would become another user, who may not read the folder.
  const std::string user = ::geteuid() == 0 ? "user root\n" : "";
  write_plain(folder_ / "mosquitto.conf", user + "listener " + std::to_string(port_) +
                                              " 127.0.0.1\npersistence false\nlog_dest stderr\nsys_interval 1\n" +
                                              extra);
}

void BrokerProcess::start() {
  program_ = std::make_unique<Program>(kMosquitto, std::vector<std::string>{"-c", folder_ / "mosquitto.conf"});
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (!takes_connections(port_)) {
    if (!program_->is_running() || std::chrono::steady_clock::now() > give_up) {
      throw std::runtime_error("mosquitto did not start: " + program_->finish(std::chrono::milliseconds(0)).err);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

}  // namespace g3d::test
