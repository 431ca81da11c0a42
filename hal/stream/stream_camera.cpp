// SPDX-License-Identifier: Apache-2.0
#include "hal/stream/stream_camera.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <thread>
#include <utility>

namespace g3d::hal {
namespace {

// So that frames of a usual camera in the place of a smaller one are known for what they are.
constexpr std::size_t kUsual_pixels = std::size_t{640} * 480;
constexpr int kEyeLook_ms = 50;  // how often it looks whether it is to end

std::string text_of(const CameraModel& camera) {
  return fmt::format("{}x{} fx {} fy {} cx {} cy {}, {} units per metre", camera.width_px, camera.height_px,
                     camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px, camera.depth_units_per_metre);
}

}  // namespace

StreamCamera::StreamCamera(StreamPlace place, const CameraModel& model, Clock& clock, std::uint32_t slow_percent)
    : model_(model),
      clock_(clock),
      slow_percent_(slow_percent),
      link_(StreamLink::dial(std::move(place))),
      reader_(std::max(model.pixel_count(), kUsual_pixels)) {}

CameraRead StreamCamera::read(Frame& out) {
  while (!stopped_.load(std::memory_order_acquire)) {
    const TimeNs now_ns = clock_.now();
    const int fd = link_.connection(now_ns);
    if (fd < 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(kEyeLook_ms / 5));
      continue;
    }
    if (link_.connections() != seen_connections_) begin_stream(now_ns);
    switch (reader_.next()) {
      case FrameStreamReader::Got::image:
        heard_ns_ = now_ns;
        if (!is_ours()) {
          ++counts_.wrong_camera;
          return {CameraEvent::dropped, DropReason::wrong_size};
        }
        if (deliver(out)) return {CameraEvent::frame, {}};
        continue;
      case FrameStreamReader::Got::sign_of_life:
        heard_ns_ = now_ns;
        ++counts_.signs_of_life;
        continue;
      case FrameStreamReader::Got::nothing:
        break;
    }
    message_began_ns_ = reader_.pending_bytes() == 0 ? -1 : message_began_ns_ < 0 ? came_ns_ : message_began_ns_;
    const Wait wait = wait_for_bytes(fd);
    if (wait == Wait::broken) {
      hang_up(clock_.now());
    } else if (clock_.now() - heard_ns_ > kStall_ns) {
      ++counts_.stalls;
      hang_up(clock_.now());
    }
  }
  return {CameraEvent::end, {}};
}

StreamCamera::Wait StreamCamera::wait_for_bytes(int fd) {
  pollfd wait{fd, POLLIN, 0};
  if (::poll(&wait, 1, kEyeLook_ms) <= 0) return Wait::in_vain;
  const std::span<std::uint8_t> room = reader_.room();
  const ssize_t count = ::read(fd, room.data(), room.size());
  // A stream that has an event but no bytes has ended.
  if (count < 0 && (errno == EAGAIN || errno == EINTR) && (wait.revents & POLLIN) != 0) return Wait::in_vain;
  if (count <= 0) return Wait::broken;
  const TimeNs now_ns = clock_.now();
  if (now_ns - came_ns_ >= kQuiet_ns && reader_.pending_bytes() == 0) is_settled_ = true;
  came_ns_ = now_ns;
  reader_.take(static_cast<std::size_t>(count));
  return Wait::over;
}

void StreamCamera::begin_stream(TimeNs now_ns) {
  seen_connections_ = link_.connections();
  reader_.clear();
  fit_.forget();
  opened_ns_ = heard_ns_ = came_ns_ = now_ns;
  message_began_ns_ = -1;
  is_settled_ = has_sequence_ = false;
}

void StreamCamera::hang_up(TimeNs now_ns) { link_.hang_up(now_ns); }

bool StreamCamera::is_ours() {
  const FrameHeader& header = reader_.header();
  if (header.slow_percent != slow_percent_ && last_error_.empty()) {
    last_error_ =
        fmt::format("{}: the camera's clock is {:g} times slow and ours {:g} times; give both the same --slow",
                    to_string(link_.place()), header.slow_percent / 100.0, slow_percent_ / 100.0);
  }
  if (header.camera == model_) return true;
  if (counts_.wrong_camera == 0) {
    last_error_ = fmt::format("{}: the stream's camera is {}, but ours {}; set [camera] in the board file, or --camera",
                              to_string(link_.place()), text_of(header.camera), text_of(model_));
  }
  return false;
}

bool StreamCamera::deliver(Frame& out) {
  const FrameHeader& header = reader_.header();
  // What began to come before the other bytes did has waited for them.
  const TimeNs ours_ns = message_began_ns_ >= 0 ? message_began_ns_ : came_ns_;
  message_began_ns_ = -1;
  const TimeNs stamp_ns = fit_.to_ours(header.stamp_ns, ours_ns);
  if (has_sequence_ && header.sequence > last_sequence_) counts_.missing += header.sequence - last_sequence_ - 1;
  has_sequence_ = true;
  last_sequence_ = header.sequence;
  if (!is_settled_ && ours_ns - opened_ns_ < kSettle_ns) {
    ++counts_.settling;
    return false;
  }
  reader_.copy_to(out);
  out.stamp_ns = stamp_ns;
  ++counts_.images;
  counts_.longest_wait_ns = std::max(counts_.longest_wait_ns, fit_.waited_ns());
  return true;
}

StreamCounts StreamCamera::counts() const {
  StreamCounts counts = counts_;
  counts.connections = link_.connections();
  counts.skipped_bytes = reader_.skipped_bytes();
  counts.rejects = reader_.rejects();
  return counts;
}

}  // namespace g3d::hal
