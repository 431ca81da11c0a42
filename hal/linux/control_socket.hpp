// SPDX-License-Identifier: Apache-2.0
// A socket in a folder by which people on the same machine ask a program that runs: one request of a few bytes, one
// answer, and the connection is over. Only the user who started the program (and root) may connect. A thread of its own
// serves it; nothing else ever waits for it.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <thread>

#include "hal/result.hpp"

namespace g3d::hal {

struct ControlCounts {
  std::uint64_t answered = 0;
  std::uint64_t too_long = 0;  ///< requests beyond kMostRequest_bytes: refused whole
  std::uint64_t too_slow = 0;  ///< connections without a request within a second, or that took no answer
  std::uint64_t too_many = 0;  ///< connections beyond kMostClients
  [[nodiscard]] std::uint64_t rejected() const { return too_long + too_slow + too_many; }
};

class ControlSocket {
 public:
  static constexpr std::size_t kMostRequest_bytes = 64;
  static constexpr std::size_t kMostAnswer_bytes = 128 * 1024;
  static constexpr std::size_t kMostClients = 8;
  /// Request -> answer, at most kMostAnswer_bytes. Called by the socket's thread alone, for one request at a time.
  using Answer = std::function<std::string(std::string_view request)>;

  /// Makes the socket and begins to serve. One that a killed program left is replaced. Errors: no_capacity (a program
  /// that runs serves it), no_permission (something else has that name, or the folder is not writable), too_large (the
  /// path), not_found, io_error.
  [[nodiscard]] static Result<std::unique_ptr<ControlSocket>> open(const std::string& path, Answer answer);
  /// Removes it again.
  ~ControlSocket();
  ControlSocket(const ControlSocket&) = delete;
  ControlSocket& operator=(const ControlSocket&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }
  /// Any thread.
  [[nodiscard]] ControlCounts counts() const;

 private:
  struct Client {
    int fd = -1;
    std::int64_t until_ms = 0;
  };
  ControlSocket(std::string path, int listener, int wake, Answer answer);
  void serve();
  void accept_one(std::array<Client, kMostClients>& clients);
  [[nodiscard]] bool serve_one(int fd);

  const std::string path_;
  const int listener_;
  const int wake_;  ///< an eventfd: readable once it is to end
  const Answer answer_;
  std::atomic<std::uint64_t> answered_{0}, too_long_{0}, too_slow_{0}, too_many_{0};
  std::thread thread_;
};

/// The other side: one request, one answer. Errors: not_found (no socket), no_capacity (nobody serves it),
/// no_permission, io_error (no answer within `patience_ms`).
[[nodiscard]] Result<std::string> ask_control_socket(const std::string& path, std::string_view request,
                                                     int patience_ms = 3000);

}  // namespace g3d::hal
