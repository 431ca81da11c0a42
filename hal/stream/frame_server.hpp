// SPDX-License-Identifier: Apache-2.0
// Sends what a depth camera gives to whoever is at the other end of a byte stream, as frame messages. The camera never
// waits for a reader: while one message is under way, of the frames that come meanwhile only the newest follows it.
//
//   camera thread ──newest frame, a ring of one──▶ sender thread ──▶ stream
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <thread>

#include "hal/clock.hpp"
#include "hal/depth_camera.hpp"
#include "hal/frame_pool.hpp"
#include "hal/linux/stream_link.hpp"
#include "hal/ring.hpp"

namespace g3d::hal {

struct ServedCounts {
  bool is_connected = false;
  std::uint64_t connections = 0;
  std::uint64_t frames = 0;       ///< taken while somebody was there
  std::uint64_t sent = 0;         ///< whole, into the stream
  std::uint64_t slow_reader = 0;  ///< of the frames, those that a newer one overtook
  std::uint64_t cut_off = 0;      ///< those under way when the stream broke or ended
  std::uint64_t sent_bytes = 0;
  std::uint64_t signs_of_life = 0;
};

class FrameServer {
 public:
  static constexpr TimeNs kSignEvery_ns = 500'000'000;  ///< without a frame

  /// Begins at once. Camera and clock outlive this. `end_camera` makes the camera's read() return. `on_frame` sees
  /// every frame that is taken; the camera's thread. Where nobody is there, the camera is not read.
  FrameServer(DepthCamera& camera, std::function<void()> end_camera, StreamLink link, Clock& clock,
              std::uint32_t slow_percent, std::function<void(const Frame&)> on_frame);
  ~FrameServer();
  FrameServer(const FrameServer&) = delete;
  FrameServer& operator=(const FrameServer&) = delete;

  /// Any thread.
  [[nodiscard]] ServedCounts counts() const;

 private:
  void camera_loop();
  void sender_loop();
  void look_after_link();
  void begin_message();
  void send_some();
  void break_off();
  void wait() const;

  DepthCamera& camera_;
  const std::function<void()> end_camera_;
  Clock& clock_;
  const std::uint32_t slow_percent_;
  const std::function<void(const Frame&)> on_frame_;
  const int wake_;  ///< an eventfd: a frame has come, or it is to end
  FramePool pool_;
  Ring<std::uint32_t> newest_{1};
  // The sender's
  StreamLink link_;
  std::unique_ptr<std::uint8_t[]> message_;
  std::size_t message_bytes_ = 0;
  std::size_t sent_bytes_ = 0;
  bool is_image_ = false;
  std::uint64_t seen_connections_ = 0;
  TimeNs last_sent_ns_ = 0;

  std::atomic<bool> stop_{false}, connected_{false};
  std::atomic<std::uint64_t> connections_{0}, frames_{0}, sent_{0}, slow_reader_{0}, cut_off_{0}, all_bytes_{0},
      signs_{0};
  std::thread camera_thread_, sender_thread_;
};

}  // namespace g3d::hal
