// SPDX-License-Identifier: Apache-2.0
// Everything that a live run's map is made of, into a folder in TUM's layout that `replay` maps again to the same map:
//
//   camera.txt                    the camera
//   depth/ rgb/ depth.txt rgb.txt every frame that the camera delivered, as packed_image.hpp has it
//   trajectory.tum                the exact pose of each frame that was mapped
//   mapped.txt                    what else the map depends on: see replay/recording.hpp
//
//   camera thread ──copies of frames, preallocated, a ring──▶ writer thread ──▶ files
//   mapper thread ──what was mapped, a ring─────────────────────▲
//
// Nobody ever waits for the writer: what it has no room for, or what the disk refuses, is lost and counted. A file is
// listed only once it is whole, so that a recording that ends in the middle can be read.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "hal/frame_pool.hpp"
#include "hal/messages.hpp"
#include "hal/parking.hpp"
#include "hal/record/append_file.hpp"
#include "hal/record/packed_image.hpp"
#include "hal/result.hpp"
#include "hal/ring.hpp"

namespace g3d::hal {

/// One frame that is in the map now.
struct MappedNote {
  TimeNs stamp_ns = 0;
  Pose T_world_camera;
  /// Of the first frame: what was taken as free before, x y z radius height in metres.
  std::optional<std::array<double, 5>> footprint;
};

struct RecordCounts {
  std::uint64_t delivered = 0;     ///< frames that the camera gave = written + lost
  std::uint64_t written = 0;       ///< whole, and listed
  std::uint64_t lost_behind = 0;   ///< the writer was behind
  std::uint64_t lost_disk = 0;     ///< the disk refused them, full or broken
  std::uint64_t lost_colours = 0;  ///< of frames that are written, the disk refused the colour
  std::uint64_t poses = 0;         ///< mapped frames = written + lost
  std::uint64_t lost_poses = 0;
  std::uint64_t masked = 0;  ///< of the poses, those of frames that were mapped without a teammate's body
  std::uint64_t bytes = 0;   ///< in files
  std::int64_t writer_cpu_ns = 0;
};

class FrameRecorder {
 public:
  /// Makes the folders and empty files in `folder`, which exists, and starts the writer. With colour or without.
  [[nodiscard]] static Result<std::unique_ptr<FrameRecorder>> create(const std::string& folder,
                                                                     const CameraModel& camera, bool with_colour);
  ~FrameRecorder();
  FrameRecorder(const FrameRecorder&) = delete;
  FrameRecorder& operator=(const FrameRecorder&) = delete;

  /// The camera's thread, each frame once. Never waits; copies the frame.
  void put_frame(const Frame& frame);
  /// The mapper's thread, in the order of the map. `masked`: the frame as it was mapped, where that is not as it came.
  void put_mapped(const MappedNote& note, const Frame* masked);
  /// Both threads have ended: writes what is left. Errors: the first that occurred.
  [[nodiscard]] Result<void> finish();
  /// After finish(): a line of mapped.txt.
  [[nodiscard]] Result<void> note(const std::string& line);
  /// Any thread.
  [[nodiscard]] RecordCounts counts() const;

 private:
  struct Files {
    AppendFile depth_list, rgb_list, trajectory, mapped;
  };
  struct Mapped {
    MappedNote note;
    std::int32_t masked_index = -1;
  };
  FrameRecorder(std::string folder, const CameraModel& camera, bool with_colour, Files files);
  void write_all();
  void write_frame(const Frame& frame);
  void write_mapped(const Mapped& mapped);
  [[nodiscard]] bool write_file(const char* kind, TimeNs stamp_ns, std::span<const std::uint8_t> bytes);
  [[nodiscard]] bool append(AppendFile& file, std::string_view line);
  void count(std::atomic<std::uint64_t>& counter) { counter.fetch_add(1, std::memory_order_relaxed); }

  const std::string folder_;
  const CameraModel camera_;
  const bool with_colour_;
  Files files_;
  ImagePacker packer_;
  FramePool frames_;
  Ring<std::uint32_t> to_write_;
  FramePool masks_;
  Ring<Mapped> mapped_;
  Parking writer_waits_;
  std::atomic<std::uint64_t> delivered_{0}, written_{0}, behind_{0}, disk_{0}, colours_{0}, poses_{0}, lost_poses_{0},
      masked_{0}, bytes_{0};
  std::atomic<std::int64_t> cpu_ns_{0};
  // The writer's, read after it was joined
  std::optional<Error> first_error_;
  std::string path_;  ///< of the file of the moment; keeps its capacity
  std::string line_;
  std::thread writer_;
};

}  // namespace g3d::hal
