// SPDX-License-Identifier: Apache-2.0
// TCP over IPv4 without surprises: nothing here waits longer than it is told, a peer that is gone raises no signal, and
// addresses are numbers. One thread at a time for each object.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include "hal/linux/ipv4_endpoint.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

/// A connection. Its descriptor never blocks by itself; poll() it where something is to be waited for.
class TcpLink {
 public:
  /// Errors: not_found (nobody listens, no way), io_error (no answer in time).
  [[nodiscard]] static Result<TcpLink> connect(const Ipv4Endpoint& to, int patience_ms);
  TcpLink() = default;
  explicit TcpLink(int fd) : fd_(fd) {}
  TcpLink(TcpLink&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  TcpLink& operator=(TcpLink&& other) noexcept;
  ~TcpLink();

  [[nodiscard]] int fd() const { return fd_; }
  [[nodiscard]] bool is_open() const { return fd_ >= 0; }
  void close();
  /// The other side reads an end; what it still sends can be read.
  void say_no_more();

  enum class Outcome : std::uint8_t { done, not_yet, over };
  /// What there is, or what there is room for; `over`: the other side has ended, or the connection is broken.
  [[nodiscard]] Outcome receive(std::span<std::uint8_t> bytes, std::size_t& count);
  [[nodiscard]] Outcome send(std::span<const std::uint8_t> bytes, std::size_t& count);

  /// All of it within `patience_ms` of silence, or false: too late, or over.
  [[nodiscard]] bool receive_all(std::span<std::uint8_t> bytes, int patience_ms);
  [[nodiscard]] bool send_all(std::span<const std::uint8_t> bytes, int patience_ms);

 private:
  [[nodiscard]] bool wait(short events, int patience_ms) const;
  int fd_ = -1;
};

class TcpListener {
 public:
  /// Port 0: any. Errors: no_capacity (taken), no_permission, not_found (not an address of this machine), io_error.
  [[nodiscard]] static Result<TcpListener> open(const Ipv4Endpoint& at);
  TcpListener(TcpListener&& other) noexcept : fd_(std::exchange(other.fd_, -1)), at_(other.at_) {}
  TcpListener& operator=(TcpListener&&) = delete;
  ~TcpListener();

  [[nodiscard]] int fd() const { return fd_; }
  [[nodiscard]] const Ipv4Endpoint& endpoint() const { return at_; }
  /// Does not wait.
  [[nodiscard]] std::optional<TcpLink> accept(Ipv4Endpoint& from);

 private:
  TcpListener(int fd, const Ipv4Endpoint& at) : fd_(fd), at_(at) {}
  int fd_;
  Ipv4Endpoint at_;
};

}  // namespace g3d::hal
