// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/udp_socket.hpp"

#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <vector>

#include "hal/linux/inet_socket.hpp"

namespace g3d::hal {
namespace {

constexpr std::size_t kBatchDatagrams = 32;
constexpr int kMostBatchesAtOnce = 8;
/// Larger ones travel in pieces, of which every one must arrive.
constexpr std::size_t kMostUdp_bytes = 65507;
constexpr std::size_t kOverflowControl_bytes = CMSG_SPACE(sizeof(std::uint32_t));

Ipv4Endpoint endpoint_of(const sockaddr_in& address) {
  return {ntohl(address.sin_addr.s_addr), ntohs(address.sin_port)};
}

bool set_option(int fd, int level, int option, int value) {
  return ::setsockopt(fd, level, option, &value, sizeof value) == 0;
}

Error udp_error(const Ipv4Endpoint& at, const char* what, int error) { return socket_error("udp", at, what, error); }

}  // namespace

struct UdpSocket::Batch {
  explicit Batch(std::size_t most_bytes) : bytes(kBatchDatagrams * most_bytes) {
    for (std::size_t i = 0; i < kBatchDatagrams; ++i) {
      parts[i] = {bytes.data() + i * most_bytes, most_bytes};
      msghdr& header = headers[i].msg_hdr;
      header.msg_name = &from[i];
      header.msg_iov = &parts[i];
      header.msg_iovlen = 1;
      header.msg_control = control[i].data();
    }
    prepare();
  }
  /// The kernel writes how much it has used.
  void prepare() {
    for (mmsghdr& one : headers) {
      one.msg_hdr.msg_namelen = sizeof(sockaddr_in);
      one.msg_hdr.msg_controllen = kOverflowControl_bytes;
      one.msg_hdr.msg_flags = 0;
    }
  }
  std::vector<std::uint8_t> bytes;
  std::array<mmsghdr, kBatchDatagrams> headers{};
  std::array<iovec, kBatchDatagrams> parts{};
  std::array<sockaddr_in, kBatchDatagrams> from{};
  alignas(cmsghdr) std::array<std::array<std::uint8_t, kOverflowControl_bytes>, kBatchDatagrams> control{};
};

UdpSocket::UdpSocket(int fd, const UdpSocketOptions& options)
    : fd_(fd),
      most_datagram_bytes_(options.most_datagram_bytes),
      batch_(std::make_unique<Batch>(options.most_datagram_bytes)) {}

UdpSocket::~UdpSocket() { ::close(fd_); }

Result<std::unique_ptr<UdpSocket>> UdpSocket::open(const UdpSocketOptions& options) {
  if (options.most_datagram_bytes == 0 || options.most_datagram_bytes > kMostUdp_bytes) {
    return Error{Reason::bad_usage, fmt::format("udp {}: datagrams have 1 to {} bytes, not {}", to_string(options.bind),
                                                kMostUdp_bytes, options.most_datagram_bytes)};
  }
  const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return udp_error(options.bind, "no socket", errno);
  std::unique_ptr<UdpSocket> socket(new UdpSocket(fd, options));
  if (const auto configured = socket->configure(options); !configured) return configured.error();
  return socket;
}

Result<void> UdpSocket::configure(const UdpSocketOptions& options) {
  if (options.shares_port &&
      (!set_option(fd_, SOL_SOCKET, SO_REUSEADDR, 1) || !set_option(fd_, SOL_SOCKET, SO_REUSEPORT, 1))) {
    return udp_error(options.bind, "cannot share its port", errno);
  }
  // IP_MULTICAST_ALL: without it a socket gets what is sent to groups that others of this machine have joined.
  if (!set_option(fd_, IPPROTO_IP, IP_MULTICAST_TTL, options.multicast_ttl) ||
      !set_option(fd_, IPPROTO_IP, IP_MULTICAST_LOOP, 1) || !set_option(fd_, IPPROTO_IP, IP_MULTICAST_ALL, 0)) {
    return udp_error(options.bind, "cannot be set up for multicast", errno);
  }
  // Root may have more than the system's limit; whoever may not gets up to the limit.
  if (!set_option(fd_, SOL_SOCKET, SO_RCVBUFFORCE, options.receive_buffer_bytes)) {
    (void)set_option(fd_, SOL_SOCKET, SO_RCVBUF, options.receive_buffer_bytes);
  }
  (void)set_option(fd_, SOL_SOCKET, SO_RXQ_OVFL, 1);
  sockaddr_in address = system_address(options.bind);
  if (::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    return udp_error(options.bind, "cannot listen", errno);
  }
  socklen_t size = sizeof address;
  if (::getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    return udp_error(options.bind, "has no name", errno);
  }
  bound_ = endpoint_of(address);
  size = sizeof receive_buffer_bytes_;
  (void)::getsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &receive_buffer_bytes_, &size);
  return {};
}

bool UdpSocket::send(const Ipv4Endpoint& to, std::span<const std::uint8_t> datagram,
                     const std::optional<Leaving>& leaving) {
  sockaddr_in address = system_address(to);
  iovec part{const_cast<std::uint8_t*>(datagram.data()), datagram.size()};
  msghdr message{};
  message.msg_name = &address;
  message.msg_namelen = sizeof address;
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  alignas(cmsghdr) std::array<std::uint8_t, CMSG_SPACE(sizeof(in_pktinfo))> control{};
  if (leaving) {
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    cmsghdr* const header = CMSG_FIRSTHDR(&message);
    header->cmsg_level = IPPROTO_IP;
    header->cmsg_type = IP_PKTINFO;
    header->cmsg_len = CMSG_LEN(sizeof(in_pktinfo));
    in_pktinfo info{};
    info.ipi_ifindex = leaving->interface_index;
    info.ipi_spec_dst.s_addr = htonl(leaving->source_ipv4);
    std::memcpy(CMSG_DATA(header), &info, sizeof info);
  }
  ssize_t size = 0;
  do {
    size = ::sendmsg(fd_, &message, MSG_DONTWAIT | MSG_NOSIGNAL);
  } while (size < 0 && errno == EINTR);
  if (size >= 0) {
    ++counts_.sent;
    counts_.sent_bytes += datagram.size();
    return true;
  }
  switch (errno) {
    case EAGAIN:
    case ENOBUFS:
      ++counts_.would_block;
      break;
    case ENETUNREACH:
    case EHOSTUNREACH:
    case ENETDOWN:
    case ENODEV:
    case EADDRNOTAVAIL:
      ++counts_.unreachable;
      break;
    default:
      ++counts_.not_sent;
  }
  return false;
}

void UdpSocket::note_overflow(std::uint32_t total) {
  counts_.overflowed += static_cast<std::uint32_t>(total - overflow_total_);
  overflow_total_ = total;
}

void UdpSocket::read_batch() {
  batch_next_ = batch_count_ = 0;
  batch_->prepare();
  int count = 0;
  do {
    count = ::recvmmsg(fd_, batch_->headers.data(), kBatchDatagrams, MSG_DONTWAIT, nullptr);
  } while (count < 0 && errno == EINTR);
  if (count < 0) {
    if (errno != EAGAIN) ++counts_.failed_reads;
    return;
  }
  batch_count_ = static_cast<std::size_t>(count);
}

std::optional<UdpSocket::Received> UdpSocket::receive() {
  // A batch of nothing but what is dropped is followed by another one, or a flood of them would hide all else.
  for (int batches = 0; batches < kMostBatchesAtOnce; ++batches) {
    if (batch_next_ == batch_count_) read_batch();
    if (batch_count_ == 0) break;
    while (batch_next_ < batch_count_) {
      if (const auto received = take(batch_next_++)) return received;
    }
  }
  return std::nullopt;
}

std::optional<UdpSocket::Received> UdpSocket::take(std::size_t at) {
  mmsghdr& one = batch_->headers[at];
  for (cmsghdr* header = CMSG_FIRSTHDR(&one.msg_hdr); header != nullptr; header = CMSG_NXTHDR(&one.msg_hdr, header)) {
    if (header->cmsg_level != SOL_SOCKET || header->cmsg_type != SO_RXQ_OVFL) continue;
    std::uint32_t total = 0;
    std::memcpy(&total, CMSG_DATA(header), sizeof total);
    note_overflow(total);
  }
  const Ipv4Endpoint from = endpoint_of(batch_->from[at]);
  if ((one.msg_hdr.msg_flags & MSG_TRUNC) != 0) {
    ++counts_.too_long;
  } else if (one.msg_hdr.msg_namelen != sizeof(sockaddr_in) || from.port == 0 || from.ipv4 == 0) {
    ++counts_.no_return;
  } else {
    ++counts_.received;
    counts_.received_bytes += one.msg_len;
    return Received{from, {batch_->bytes.data() + at * most_datagram_bytes_, one.msg_len}};
  }
  return std::nullopt;
}

}  // namespace g3d::hal
