// SPDX-License-Identifier: Apache-2.0
// A machine that takes updates at a port of its own, in a thread, until it has one or is stopped.
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "net/update_server.hpp"
#include "tests/support/slot_machine.hpp"

namespace g3d::test {

/// Nobody is too slow, on however busy a machine.
[[nodiscard]] inline net::UpdateServerOptions patient_server() {
  net::UpdateServerOptions options;
  options.proof_patience_ns = options.chunk_patience_ns = options.takeover_ns = 100'000 * hal::kMillisecond_ns;
  return options;
}

class UpdateHost {
 public:
  explicit UpdateHost(SlotMachine& machine, net::UpdateServerOptions options = patient_server())
      : target_(machine.paths()) {
    options.at = {0x7F000001, 0};
    options.rate_Bps = std::max(options.rate_Bps, 1e9);
    auto opened = net::UpdateServer::open(options, machine.key.update_key(), target_, [this](const std::string& line) {
      const std::lock_guard lock(mutex_);
      told_ += line + "\n";
    });
    REQUIRE(opened.ok());
    server_ = std::move(opened).value();
    thread_ = std::thread([this] { is_installed_ = server_->serve(); });
  }
  ~UpdateHost() { (void)stop(); }
  UpdateHost(const UpdateHost&) = delete;
  UpdateHost& operator=(const UpdateHost&) = delete;

  [[nodiscard]] hal::Ipv4Endpoint at() const { return {0x7F000001, server_->port()}; }
  /// Waits for the end that comes by itself: whether an update was installed.
  bool join() {
    if (thread_.joinable()) thread_.join();
    return is_installed_;
  }
  bool stop() {
    server_->stop();
    return join();
  }
  /// After join() or stop().
  [[nodiscard]] const net::UpdateServerCounts& counts() const { return server_->counts(); }
  [[nodiscard]] std::string told() {
    const std::lock_guard lock(mutex_);
    return told_;
  }

 private:
  net::UpdateTarget target_;
  std::unique_ptr<net::UpdateServer> server_;
  std::mutex mutex_;
  std::string told_;
  bool is_installed_ = false;
  std::thread thread_;
};

}  // namespace g3d::test
