// SPDX-License-Identifier: Apache-2.0
// What a recording of `g3dmap run --record` has besides frames and poses, so that the map can be made again exactly:
// mapped.txt, one of these per line, `#` begins a comment.
//
//   footprint X Y Z RADIUS HEIGHT   metres in the world; taken as free before the first frame was mapped
//   masked STAMP FILE               this frame was mapped with the depth image FILE instead, without a teammate's body
//   colour no                       the run kept occupancy only
//   cannot WHY                      the map of the run was made of more than what is here
//   map HASH                        of the run's map, at its end
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/depth_camera.hpp"
#include "hal/record/packed_image.hpp"
#include "hal/replay/trajectory_file.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

struct RecordedFootprint {
  std::array<double, 3> at_m{};
  double radius_m = 0.0;
  double height_m = 0.0;
};

struct MappedLog {
  std::optional<RecordedFootprint> footprint;
  std::map<TimeNs, std::string> masked;  ///< stamp -> file, relative to the folder, never leaving it
  bool with_colour = true;
  std::vector<std::string> cannot;
  std::string hash;  ///< empty: the run did not come to its end
};

inline constexpr std::size_t kMaxMappedLog_bytes = std::size_t{1} << 28;

/// Errors name `name`:line. A last line without its line feed, as a cut power line leaves it, is not looked at.
[[nodiscard]] Result<MappedLog> parse_mapped_log(std::string_view text, std::string_view name);

/// Poses as they were, to the last bit, at the stamps that they have and nowhere else.
class ExactPoses final : public PoseSource {
 public:
  /// `poses` sorted by stamp.
  explicit ExactPoses(std::vector<StampedPose> poses) : poses_(std::move(poses)) {}
  [[nodiscard]] PoseStatus pose_at(TimeNs stamp_ns, Pose& T_world_camera) const override;
  [[nodiscard]] std::size_t count() const { return poses_.size(); }

 private:
  std::vector<StampedPose> poses_;
};

/// A recorded camera whose masked frames come as they were mapped.
class MaskedCamera final : public DepthCamera {
 public:
  /// Both outlive this.
  MaskedCamera(DepthCamera& camera, const std::string& folder, const std::map<TimeNs, std::string>& masked)
      : camera_(camera), folder_(folder), masked_(masked) {}

  [[nodiscard]] const CameraModel& model() const override { return camera_.model(); }
  [[nodiscard]] CameraRead read(Frame& out) override;
  [[nodiscard]] std::optional<std::size_t> frame_count() const override { return camera_.frame_count(); }
  [[nodiscard]] std::string last_error() const override {
    return last_error_.empty() ? camera_.last_error() : last_error_;
  }

 private:
  DepthCamera& camera_;
  const std::string folder_;
  const std::map<TimeNs, std::string>& masked_;
  ImageUnpacker unpacker_;
  std::vector<std::uint8_t> file_;
  std::string last_error_;
};

}  // namespace g3d::hal
