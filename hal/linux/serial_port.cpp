// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/serial_port.hpp"

#include <fcntl.h>
#include <linux/serial.h>
#include <string.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

namespace g3d::hal {
namespace {

std::string why() { return ::strerrordesc_np(errno) != nullptr ? ::strerrordesc_np(errno) : "unknown error"; }

Error open_error(const std::string& path) {
  switch (errno) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return {Reason::not_found, path + ": no such port; plug the base in and switch it on"};
    case EACCES:
    case EPERM:
      return {Reason::no_permission,
              path + ": may not be opened; add the user to group dialout, or install the udev rule"};
    case EBUSY:
      return {Reason::no_capacity, path + ": held by another process; end that one first"};
    default:
      return {Reason::io_error, path + ": cannot be opened: " + why()};
  }
}

LowLatency ask_for_low_latency(int fd) {
  serial_struct serial{};
  if (::ioctl(fd, TIOCGSERIAL, &serial) != 0) return LowLatency::refused;
  serial.flags |= ASYNC_LOW_LATENCY;
  return ::ioctl(fd, TIOCSSERIAL, &serial) == 0 ? LowLatency::set : LowLatency::refused;
}

}  // namespace

const char* to_string(LowLatency low_latency) {
  switch (low_latency) {
    case LowLatency::unknown:
      return "unknown";
    case LowLatency::set:
      return "set";
    case LowLatency::refused:
      return "refused";
  }
  return "unknown";
}

bool set_raw_115200(int fd) {
  termios t{};
  if (::tcgetattr(fd, &t) != 0) return false;
  ::cfmakeraw(&t);  // also 8 bits, no parity
  t.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS);
  t.c_cflag |= CLOCAL | CREAD;
  t.c_iflag &= ~static_cast<tcflag_t>(IXON | IXOFF | IXANY);
  t.c_cc[VMIN] = 1;  // with 0 a read without data would look like a hang-up
  t.c_cc[VTIME] = 0;
  return ::cfsetispeed(&t, B115200) == 0 && ::cfsetospeed(&t, B115200) == 0 && ::tcsetattr(fd, TCSANOW, &t) == 0;
}

SerialPort::SerialPort(Options options, const Clock& clock) : options_(std::move(options)), clock_(clock) {}

SerialPort::~SerialPort() { close(); }

Result<void> SerialPort::open() {
  close();
  may_retry_ = true;
  next_try_ns_ = clock_.now() + options_.retry_ns;
  const Result<std::string> found = options_.find();
  if (!found.ok()) return found.error();
  path_ = found.value();
  const int fd = ::open(path_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return open_error(path_);
  const Result<void> configured = configure(fd);
  if (!configured.ok()) {
    ::close(fd);
    return configured.error();
  }
  fd_ = fd;
  ++opened_;
  if (options_.on_open) options_.on_open(fd_);
  return {};
}

Result<void> SerialPort::configure(int fd) {
  if (::isatty(fd) == 0) return Error{Reason::unsupported, path_ + ": is no serial port"};
  // The guard process shares this lock with us: both hold the same open file.
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
    return Error{Reason::no_capacity, path_ + ": another process drives this base; end that one first"};
  }
  if (!set_raw_115200(fd)) return Error{Reason::io_error, path_ + ": refuses 115200 8N1: " + why()};
  low_latency_ = ask_for_low_latency(fd);
  (void)::tcflush(fd, TCIFLUSH);  // what lay there before is of unknown age
  return {};
}

void SerialPort::close() {
  may_retry_ = false;
  if (fd_ < 0) return;
  ::close(std::exchange(fd_, -1));
}

std::size_t SerialPort::read(std::span<std::uint8_t> into) {
  if (fd_ < 0) {
    if (!may_retry_ || clock_.now() < next_try_ns_ || !open().ok()) return 0;
  }
  if (into.empty()) return 0;
  const ssize_t count = ::read(fd_, into.data(), into.size());
  if (count > 0) return static_cast<std::size_t>(count);
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
  close();  // hung up, or an error that only a new open can end
  may_retry_ = true;
  next_try_ns_ = clock_.now() + options_.retry_ns;
  return 0;
}

bool SerialPort::write(std::span<const std::uint8_t> bytes) {
  if (fd_ < 0) return false;
  int queued = 0;
  // All or nothing: half a packet in a full queue would spoil the next one.
  constexpr int kMostQueued_bytes = 512;  // 44 ms of line; more than that is not being read
  if (::ioctl(fd_, TIOCOUTQ, &queued) == 0 && queued > kMostQueued_bytes) {
    ++refused_writes_;
    return false;
  }
  const ssize_t count = ::write(fd_, bytes.data(), bytes.size());
  if (count == static_cast<ssize_t>(bytes.size())) return true;
  ++refused_writes_;
  if (count >= 0 || errno == EAGAIN || errno == EINTR) return false;
  close();
  may_retry_ = true;
  next_try_ns_ = clock_.now() + options_.retry_ns;
  return false;
}

}  // namespace g3d::hal
