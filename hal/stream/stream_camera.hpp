// SPDX-License-Identifier: Apache-2.0
// A depth camera at the other end of a byte stream: of a simulated building in another program, or on the other side of
// an emulated machine. A stream that ends, stalls or says nothing that makes sense is opened again. Frames carry the
// time of our own clock. See frame_message.hpp for what comes over it.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>

#include "hal/clock.hpp"
#include "hal/depth_camera.hpp"
#include "hal/linux/stream_link.hpp"
#include "hal/stream/frame_reader.hpp"
#include "hal/stream/stamp_fit.hpp"

namespace g3d::hal {

/// What became of the stream so far.
struct StreamCounts {
  std::uint64_t connections = 0;
  std::uint64_t images = 0;        ///< delivered
  std::uint64_t wrong_camera = 0;  ///< images of another camera than ours
  std::uint64_t settling = 0;      ///< images from before or just after it was opened: they may be old
  std::uint64_t missing = 0;       ///< numbers that never came: lost by the sender or on the way
  std::uint64_t stalls = 0;        ///< no message for kStall_ns
  std::uint64_t signs_of_life = 0;
  std::uint64_t skipped_bytes = 0;
  std::array<std::uint64_t, kStreamRejects> rejects{};
  TimeNs longest_wait_ns = 0;  ///< of a delivered image beyond the quickest
};

class StreamCamera final : public DepthCamera {
 public:
  /// By then a sender that lives has said so.
  static constexpr TimeNs kStall_ns = 3'000'000'000;
  /// What lay in the stream when it was opened is old; how old is known once something new has come.
  static constexpr TimeNs kSettle_ns = 1'000'000'000;
  /// Nothing old lies in a stream that was empty for so long.
  static constexpr TimeNs kQuiet_ns = 100'000'000;

  /// `model`: what the stream has to bring. `clock` outlives this. `slow_percent`: of that clock; a sender with another
  /// one is named by last_error().
  StreamCamera(StreamPlace place, const CameraModel& model, Clock& clock,
               std::uint32_t slow_percent = kLeastSlow_percent);

  [[nodiscard]] const CameraModel& model() const override { return model_; }
  [[nodiscard]] CameraRead read(Frame& out) override;
  [[nodiscard]] std::string last_error() const override { return last_error_; }
  /// read() says `end` from now on. Any thread.
  void stop() { stopped_.store(true, std::memory_order_release); }
  /// By the reading thread, or after it.
  [[nodiscard]] StreamCounts counts() const;

 private:
  enum class Wait : std::uint8_t { over, broken, in_vain };
  [[nodiscard]] Wait wait_for_bytes(int fd);
  void begin_stream(TimeNs now_ns);
  void hang_up(TimeNs now_ns);
  [[nodiscard]] bool is_ours();
  [[nodiscard]] bool deliver(Frame& out);

  const CameraModel model_;
  Clock& clock_;
  const std::uint32_t slow_percent_;
  StreamLink link_;
  FrameStreamReader reader_;
  StampFit fit_;
  std::uint64_t seen_connections_ = 0;
  TimeNs opened_ns_ = 0;
  TimeNs heard_ns_ = 0;
  TimeNs message_began_ns_ = -1;  ///< of the message that is not whole yet
  TimeNs came_ns_ = 0;            ///< when the last bytes came
  bool is_settled_ = false;       ///< what comes is new
  bool has_sequence_ = false;
  std::uint64_t last_sequence_ = 0;
  StreamCounts counts_;
  std::string last_error_;
  std::atomic<bool> stopped_{false};
};

}  // namespace g3d::hal
