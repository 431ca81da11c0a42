// SPDX-License-Identifier: Apache-2.0
// The free scan mask as a picture: for every pixel the raw depth up to which its ray may carve when it has no reading.
// It is made from a recording of a plain wall that fills the view, a 16-bit PNG of the camera's size; 0 carves nothing.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hal/messages.hpp"
#include "hal/result.hpp"

namespace g3d::mapper {

/// Collects wall views. The nearest reading that a pixel ever gave counts: a mask must not promise too much. A pixel
/// that never gave one (the band that registration leaves empty) stays 0.
class ScanMaskBuilder {
 public:
  explicit ScanMaskBuilder(const hal::CameraModel& camera);
  /// `frame` has the camera's size.
  void add(const hal::Frame& frame);

  [[nodiscard]] const std::vector<std::uint16_t>& mask() const { return mask_; }
  /// Share of the pixels that ever gave a reading, 0..1.
  [[nodiscard]] double coverage() const;

 private:
  std::vector<std::uint16_t> mask_;
};

[[nodiscard]] hal::Result<void> save_scan_mask(const std::string& path, const hal::CameraModel& camera,
                                               const std::vector<std::uint16_t>& mask);
/// Refuses a picture of another size or kind (out_of_range, unsupported).
[[nodiscard]] hal::Result<std::vector<std::uint16_t>> load_scan_mask(const std::string& path,
                                                                     const hal::CameraModel& camera);

}  // namespace g3d::mapper
