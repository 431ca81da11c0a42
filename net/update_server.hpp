// SPDX-License-Identifier: Apache-2.0
// Takes updates from the network: listens, tells the one who holds the key from all others, and hands its bytes to an
// UpdateIntake. Those who have proved nothing yet cost a few hundred bytes each, wait in a handful of places, and give
// way to newer ones after some seconds. One update at a time: another sender is told so, unless the first one has
// fallen silent. The loop runs in the caller's thread and blocks on the disk; nothing of the robot waits for it.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "hal/clock.hpp"
#include "hal/linux/tcp_link.hpp"
#include "net/update_intake.hpp"

namespace g3d::net {

struct UpdateServerOptions {
  hal::Ipv4Endpoint at{0, kUpdatePort};
  double rate_Bps = 4e6;
  hal::TimeNs proof_patience_ns = 5'000 * hal::kMillisecond_ns;
  hal::TimeNs chunk_patience_ns = 20'000 * hal::kMillisecond_ns;
  /// One who proves itself takes over from a sender that has been silent for so long.
  hal::TimeNs takeover_ns = 3'000 * hal::kMillisecond_ns;
};

struct UpdateServerCounts {
  std::uint64_t connections = 0;
  std::uint64_t proved = 0;
  std::uint64_t crowded_out = 0;  ///< before they proved anything, by newer ones
  std::array<std::uint64_t, static_cast<std::size_t>(UpdateEnd::count_)> ends{};
  std::uint64_t cut = 0;  ///< connections that were simply gone
  [[nodiscard]] std::uint64_t of(UpdateEnd end) const { return ends[static_cast<std::size_t>(end)]; }
};

class UpdateServer {
 public:
  static constexpr std::size_t kMostConnections = 6;
  /// One line per event, for the log.
  using Tell = std::function<void(const std::string&)>;

  [[nodiscard]] static hal::Result<std::unique_ptr<UpdateServer>> open(const UpdateServerOptions& options,
                                                                       const UpdateKey& key, UpdateTarget& target,
                                                                       Tell tell);
  ~UpdateServer();
  UpdateServer(const UpdateServer&) = delete;
  UpdateServer& operator=(const UpdateServer&) = delete;

  [[nodiscard]] std::uint16_t port() const { return listener_.endpoint().port; }
  /// Until an update is installed (true; its sender has been told) or stop() was called (false).
  bool serve();
  /// Any thread, and signal handlers.
  void stop();
  /// After serve(), or by its thread.
  [[nodiscard]] const UpdateServerCounts& counts() const { return counts_; }

 private:
  struct Guest;
  UpdateServer(const UpdateServerOptions& options, const UpdateKey& key, UpdateTarget& target, Tell tell,
               hal::TcpListener listener, int wake);
  void welcome(hal::TimeNs now_ns);
  void attend(Guest& guest, hal::TimeNs now_ns);
  void exchange(Guest& guest, hal::TimeNs now_ns);
  void admit(Guest& guest, hal::TimeNs now_ns);
  void dismiss(Guest& guest);
  void note_end(Guest& guest, hal::TimeNs now_ns);
  [[nodiscard]] int wait_ms(hal::TimeNs now_ns) const;

  const UpdateServerOptions options_;
  const UpdateKey key_;
  UpdateTarget& target_;
  const Tell tell_;
  hal::RealClock clock_;
  hal::TcpListener listener_;
  int wake_;
  std::atomic<bool> is_stopped_{false};
  bool is_installed_ = false;
  std::array<std::unique_ptr<Guest>, kMostConnections> guests_;
  UpdateServerCounts counts_;
};

}  // namespace g3d::net
