// SPDX-License-Identifier: Apache-2.0
// A UDP socket for IPv4 that never waits: datagrams come in batches, one system call for many, and leave one by one.
// What is longer than the longest one allowed is dropped and counted. One thread; nothing allocates after open().
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "hal/linux/ipv4_endpoint.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

struct UdpSocketOptions {
  Ipv4Endpoint bind;  ///< address 0: all of this machine; a multicast group: what is sent to it; port 0: any free
  bool shares_port = false;  ///< several programs of one machine may listen; each gets what is sent to a group
  int multicast_ttl = 1;     ///< how many routers a multicast datagram passes, and one more
  std::size_t most_datagram_bytes = 1200;
  int receive_buffer_bytes = 1 << 20;  ///< what the kernel keeps for us; it may grant less
};

struct UdpSocketCounts {
  std::uint64_t sent = 0;
  std::uint64_t sent_bytes = 0;
  std::uint64_t would_block = 0;  ///< not sent: the kernel's queue is full
  std::uint64_t unreachable = 0;  ///< not sent: no network, no route, no such interface; the radio is down
  std::uint64_t not_sent = 0;     ///< not sent for another reason
  std::uint64_t received = 0;
  std::uint64_t received_bytes = 0;
  std::uint64_t too_long = 0;    ///< dropped: longer than most_datagram_bytes
  std::uint64_t no_return = 0;   ///< dropped: from nowhere that could be answered
  std::uint64_t overflowed = 0;  ///< lost in the kernel, because we came too late; known with the next one that comes
  std::uint64_t failed_reads = 0;
};

/// Which interface a datagram leaves through, and the address of ours that it names as its source.
struct Leaving {
  int interface_index = 0;
  std::uint32_t source_ipv4 = 0;
  bool operator==(const Leaving&) const = default;
};

class UdpSocket {
 public:
  /// Errors: bad_usage (a lying option), no_capacity (the port is taken), no_permission, not_found (no such address
  /// here), io_error.
  [[nodiscard]] static Result<std::unique_ptr<UdpSocket>> open(const UdpSocketOptions& options);
  ~UdpSocket();
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;

  /// Without `leaving` as the kernel routes it. False: not sent, and counted.
  bool send(const Ipv4Endpoint& to, std::span<const std::uint8_t> datagram, const std::optional<Leaving>& leaving = {});

  struct Received {
    Ipv4Endpoint from;
    std::span<const std::uint8_t> datagram;  ///< valid until the next receive()
  };
  /// The next datagram; nothing if none is there, or hundreds of others that were dropped.
  [[nodiscard]] std::optional<Received> receive();
  /// How many are left of the batch that was read last: receive() hands them over without asking the kernel.
  [[nodiscard]] std::size_t left_in_batch() const { return batch_count_ - batch_next_; }

  [[nodiscard]] int fd() const { return fd_; }
  [[nodiscard]] const Ipv4Endpoint& bound() const { return bound_; }
  /// What the kernel keeps of what has come, its own overhead included.
  [[nodiscard]] int receive_buffer_bytes() const { return receive_buffer_bytes_; }
  [[nodiscard]] const UdpSocketCounts& counts() const { return counts_; }

 private:
  struct Batch;
  UdpSocket(int fd, const UdpSocketOptions& options);
  [[nodiscard]] Result<void> configure(const UdpSocketOptions& options);
  void read_batch();
  [[nodiscard]] std::optional<Received> take(std::size_t at);
  void note_overflow(std::uint32_t total);

  const int fd_;
  const std::size_t most_datagram_bytes_;
  const std::unique_ptr<Batch> batch_;
  std::size_t batch_next_ = 0;
  std::size_t batch_count_ = 0;
  Ipv4Endpoint bound_;
  int receive_buffer_bytes_ = 0;
  std::uint32_t overflow_total_ = 0;  ///< as the kernel counts, modulo 2^32
  UdpSocketCounts counts_;
};

}  // namespace g3d::hal
