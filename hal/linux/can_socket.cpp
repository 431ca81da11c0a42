// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/can_socket.hpp"

#include <fmt/format.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace g3d::hal {
namespace {

Error can_error(const std::string& interface, const char* what, int error) {
  Reason reason = Reason::io_error;
  const char* remedy = "see dmesg for what the CAN driver says";
  if (error == ENODEV || error == ENXIO) {
    reason = Reason::not_found;
    remedy = "no such interface: load its driver, or set can.interface in the board file";
  } else if (error == EAFNOSUPPORT || error == EPROTONOSUPPORT) {
    reason = Reason::unsupported;
    remedy = "this kernel has no CAN: load the modules can and can_raw";
  } else if (error == EPERM || error == EACCES) {
    reason = Reason::no_permission;
    remedy = "run it as a user that may open raw CAN sockets";
  }
  return {reason, fmt::format("{}: {}: {}; {}", interface, what, std::strerror(error), remedy)};
}

bool is_well_formed(const can_frame& raw) {
  if (raw.can_dlc > CAN_MAX_DLEN) return false;
  return (raw.can_id & (CAN_EFF_FLAG | CAN_ERR_FLAG)) != 0 || (raw.can_id & CAN_EFF_MASK) <= CAN_SFF_MASK;
}

can::CanFrame frame_of(const can_frame& raw) {
  can::CanFrame frame;
  frame.is_error = (raw.can_id & CAN_ERR_FLAG) != 0;
  frame.is_extended = !frame.is_error && (raw.can_id & CAN_EFF_FLAG) != 0;
  frame.is_remote = !frame.is_error && (raw.can_id & CAN_RTR_FLAG) != 0;
  frame.id = raw.can_id & CAN_EFF_MASK;
  frame.size = raw.can_dlc;
  if (!frame.is_remote) std::copy_n(raw.data, frame.size, frame.data.begin());
  return frame;
}

can_frame raw_of(const can::CanFrame& frame) {
  can_frame raw{};
  raw.can_id = frame.id;
  if (frame.is_extended) raw.can_id |= CAN_EFF_FLAG;
  if (frame.is_remote) raw.can_id |= CAN_RTR_FLAG;
  raw.can_dlc = std::min<std::uint8_t>(frame.size, CAN_MAX_DLEN);
  std::copy_n(frame.data.begin(), raw.can_dlc, raw.data);
  return raw;
}

}  // namespace

Result<int> open_can_socket(const std::string& interface) {
  const int fd = ::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW);
  if (fd < 0) return can_error(interface, "no CAN socket", errno);
  const auto refuse = [&](const char* what) {
    const int error = errno;
    ::close(fd);
    return can_error(interface, what, error);
  };
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(::if_nametoindex(interface.c_str()));
  if (address.can_ifindex == 0) return refuse("is not there");
  const can_err_mask_t all_errors = CAN_ERR_MASK;
  if (::setsockopt(fd, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &all_errors, sizeof all_errors) != 0) {
    return refuse("tells of no errors");
  }
  const int on = 1;
  (void)::setsockopt(fd, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on);  // without it losses stay uncounted
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return refuse("cannot be bound");
  return fd;
}

CanSocket::CanSocket(int fd) : fd_(fd), has_socket_(fd >= 0) {}

CanSocket::~CanSocket() {
  if (fd_ >= 0) ::close(fd_);
  const int offered = offered_fd_.exchange(-1);
  if (offered >= 0) ::close(offered);
}

void CanSocket::hand_over(int fd) {
  const int before = offered_fd_.exchange(fd, std::memory_order_acq_rel);
  if (before >= 0) ::close(before);
}

void CanSocket::take_offered() {
  const int offered = offered_fd_.exchange(-1, std::memory_order_acq_rel);
  if (offered < 0) return;
  if (fd_ >= 0) ::close(fd_);
  fd_ = offered;
  overflow_total_ = 0;
  ++counts_.reopened;
  link_is_down_.store(false, std::memory_order_release);
  bus_is_off_.store(false, std::memory_order_release);
  has_socket_.store(true, std::memory_order_release);
}

void CanSocket::lose_socket() {
  if (fd_ < 0) return;
  note_down();
  ::close(std::exchange(fd_, -1));
  has_socket_.store(false, std::memory_order_release);
}

void CanSocket::note_down() {
  if (!link_is_down_.exchange(true, std::memory_order_acq_rel)) ++counts_.link_losses;
}

void CanSocket::note_error_frame(std::uint32_t classes) {
  ++counts_.error_frames;
  if ((classes & CAN_ERR_BUSOFF) != 0) {
    ++counts_.bus_offs;
    bus_is_off_.store(true, std::memory_order_release);
  }
  if ((classes & CAN_ERR_RESTARTED) != 0) {
    ++counts_.bus_restarts;
    bus_is_off_.store(false, std::memory_order_release);
  }
}

void CanSocket::note_overflow(std::uint32_t total) {
  counts_.overflowed += static_cast<std::uint32_t>(total - overflow_total_);
  overflow_total_ = total;
}

bool CanSocket::read(can::CanFrame& frame) {
  take_offered();
  // Bounded: what is dropped must not keep the caller either.
  for (int i = 0; i < 64 && fd_ >= 0; ++i) {
    can_frame raw{};
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(std::uint32_t))> control{};
    iovec part{&raw, sizeof raw};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const ssize_t count = ::recvmsg(fd_, &message, MSG_DONTWAIT);
    if (count < 0) {
      if (errno == EAGAIN || errno == EINTR) return false;
      ++counts_.failed_reads;
      if (errno == ENETDOWN) {
        note_down();  // told once; the socket stays good for when the link is up again
      } else {
        lose_socket();
      }
      return false;
    }
    if (count == 0) {
      lose_socket();
      return false;
    }
    for (const cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr; c = CMSG_NXTHDR(&message, const_cast<cmsghdr*>(c))) {
      if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SO_RXQ_OVFL) continue;
      std::uint32_t total = 0;
      std::memcpy(&total, CMSG_DATA(c), sizeof total);
      note_overflow(total);
    }
    if (count != static_cast<ssize_t>(sizeof raw) || (message.msg_flags & MSG_TRUNC) != 0 || !is_well_formed(raw)) {
      ++counts_.malformed;
      continue;
    }
    frame = frame_of(raw);
    ++counts_.received;
    link_is_down_.store(false, std::memory_order_release);
    if (frame.is_error) {
      note_error_frame(frame.id);
    } else {
      bus_is_off_.store(false, std::memory_order_release);
    }
    return true;
  }
  return false;
}

bool CanSocket::write(const can::CanFrame& frame) {
  if (fd_ < 0) {
    ++counts_.not_sent_down;
    return false;
  }
  const can_frame raw = raw_of(frame);
  if (::send(fd_, &raw, sizeof raw, MSG_DONTWAIT | MSG_NOSIGNAL) == static_cast<ssize_t>(sizeof raw)) {
    ++counts_.sent;
    return true;
  }
  switch (errno) {
    case ENOBUFS:
    case EAGAIN:
      ++counts_.send_queue_full;
      break;
    case ENETDOWN:
      ++counts_.not_sent_down;
      note_down();
      break;
    case ENODEV:
    case ENXIO:
    case EPIPE:
    case ECONNRESET:
      ++counts_.not_sent_down;
      lose_socket();
      break;
    default:
      ++counts_.not_sent;
  }
  return false;
}

}  // namespace g3d::hal
