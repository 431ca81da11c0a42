// SPDX-License-Identifier: Apache-2.0
#include "hal/stream/frame_server.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "hal/stream/frame_message.hpp"

namespace g3d::hal {
namespace {

constexpr int kServeLook_ms = 50;
constexpr TimeNs kNobody_ns = 20'000'000;
// What the kernel holds back of a message is old when it arrives.
constexpr int kSendBuffer_bytes = 64 * 1024;

}  // namespace

FrameServer::FrameServer(DepthCamera& camera, std::function<void()> end_camera, StreamLink link, Clock& clock,
                         std::uint32_t slow_percent, std::function<void(const Frame&)> on_frame)
    : camera_(camera),
      end_camera_(std::move(end_camera)),
      clock_(clock),
      slow_percent_(slow_percent),
      on_frame_(std::move(on_frame)),
      wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      pool_(camera.model(), 3),
      link_(std::move(link)),
      message_(std::make_unique<std::uint8_t[]>(most_message_bytes(camera.model()))) {
  sender_thread_ = std::thread([this] { sender_loop(); });
  camera_thread_ = std::thread([this] { camera_loop(); });
}

FrameServer::~FrameServer() {
  stop_.store(true, std::memory_order_release);
  end_camera_();
  camera_thread_.join();
  (void)::eventfd_write(wake_, 1);
  sender_thread_.join();
  if (wake_ >= 0) ::close(wake_);
}

void FrameServer::camera_loop() {
  std::uint32_t index = 0;
  bool has_frame = pool_.try_acquire(index);
  while (has_frame && !stop_.load(std::memory_order_acquire)) {
    if (!connected_.load(std::memory_order_acquire)) {
      clock_.sleep_until(clock_.now() + kNobody_ns);
      continue;
    }
    const CameraRead read = camera_.read(pool_[index]);
    if (read.event == CameraEvent::end) return;
    if (read.event != CameraEvent::frame) continue;
    frames_.fetch_add(1, std::memory_order_relaxed);
    if (on_frame_) on_frame_(pool_[index]);
    if (const auto overtaken = newest_.push_overwrite_oldest(index)) {
      slow_reader_.fetch_add(1, std::memory_order_relaxed);
      index = *overtaken;
    } else {
      has_frame = pool_.try_acquire(index);  // one waits, one is being packed: there is a third
    }
    (void)::eventfd_write(wake_, 1);
  }
}

void FrameServer::sender_loop() {
  while (!stop_.load(std::memory_order_acquire)) {
    look_after_link();
    if (link_.fd() >= 0 && message_bytes_ == 0) begin_message();
    if (link_.fd() >= 0 && message_bytes_ > 0) send_some();
    wait();
  }
  break_off();
}

void FrameServer::look_after_link() {
  const int fd = link_.connection(clock_.now());
  if (fd >= 0 && link_.connections() != seen_connections_) {
    seen_connections_ = link_.connections();
    connections_.store(seen_connections_, std::memory_order_relaxed);
    break_off();
    (void)::setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &kSendBuffer_bytes, sizeof kSendBuffer_bytes);
    last_sent_ns_ = 0;
  }
  connected_.store(fd >= 0, std::memory_order_release);
}

/// The rest of a message is no good for another stream, and what waits is old.
void FrameServer::break_off() {
  if (message_bytes_ > 0 && is_image_) cut_off_.fetch_add(1, std::memory_order_relaxed);
  message_bytes_ = 0;
  std::uint32_t index = 0;
  while (newest_.try_pop(index)) {
    cut_off_.fetch_add(1, std::memory_order_relaxed);
    pool_.release(index);
  }
}

void FrameServer::begin_message() {
  const std::span<std::uint8_t> room(message_.get(), most_message_bytes(camera_.model()));
  std::uint32_t index = 0;
  is_image_ = newest_.try_pop(index);
  if (is_image_) {
    message_bytes_ = encode_frame_message(camera_.model(), pool_[index], slow_percent_, room);
    pool_.release(index);
  } else if (clock_.now() - last_sent_ns_ >= kSignEvery_ns) {
    message_bytes_ = encode_sign_of_life(camera_.model(), clock_.now(), slow_percent_, room);
  }
  sent_bytes_ = 0;
}

void FrameServer::send_some() {
  while (sent_bytes_ < message_bytes_) {
    const ssize_t count =
        ::send(link_.fd(), message_.get() + sent_bytes_, message_bytes_ - sent_bytes_, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (count <= 0) {
      link_.hang_up(clock_.now());
      break_off();
      return;
    }
    sent_bytes_ += static_cast<std::size_t>(count);
    all_bytes_.fetch_add(static_cast<std::uint64_t>(count), std::memory_order_relaxed);
  }
  (is_image_ ? sent_ : signs_).fetch_add(1, std::memory_order_relaxed);
  message_bytes_ = 0;
  last_sent_ns_ = clock_.now();
}

void FrameServer::wait() const {
  if (!newest_.empty() && link_.fd() >= 0 && message_bytes_ == 0) return;
  pollfd waits[3] = {{wake_, POLLIN, 0},
                     {link_.fd(), static_cast<short>(message_bytes_ > 0 ? POLLOUT : 0), 0},
                     {link_.listener(), POLLIN, 0}};
  (void)::poll(waits, 3, kServeLook_ms);
  eventfd_t ignored = 0;
  if ((waits[0].revents & POLLIN) != 0) (void)::eventfd_read(wake_, &ignored);
}

ServedCounts FrameServer::counts() const {
  ServedCounts counts;
  counts.is_connected = connected_.load(std::memory_order_acquire);
  counts.connections = connections_.load(std::memory_order_relaxed);
  counts.frames = frames_.load(std::memory_order_relaxed);
  counts.sent = sent_.load(std::memory_order_relaxed);
  counts.slow_reader = slow_reader_.load(std::memory_order_relaxed);
  counts.cut_off = cut_off_.load(std::memory_order_relaxed);
  counts.sent_bytes = all_bytes_.load(std::memory_order_relaxed);
  counts.signs_of_life = signs_.load(std::memory_order_relaxed);
  return counts;
}

}  // namespace g3d::hal
