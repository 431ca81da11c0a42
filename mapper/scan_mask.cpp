// SPDX-License-Identifier: Apache-2.0
#include "mapper/scan_mask.hpp"

#include <algorithm>

#include "hal/image/file_bytes.hpp"
#include "hal/image/png_reader.hpp"
#include "hal/image/png_writer.hpp"

namespace g3d::mapper {
namespace {

constexpr std::size_t kMaxMaskFile_bytes = std::size_t{32} << 20;

}  // namespace

ScanMaskBuilder::ScanMaskBuilder(const hal::CameraModel& camera) : mask_(camera.pixel_count(), 0) {}

void ScanMaskBuilder::add(const hal::Frame& frame) {
  for (std::size_t i = 0; i < mask_.size(); ++i) {
    const std::uint16_t reading = frame.depth[i];
    if (reading != 0 && (mask_[i] == 0 || reading < mask_[i])) mask_[i] = reading;
  }
}

double ScanMaskBuilder::coverage() const {
  const auto empty = std::count(mask_.begin(), mask_.end(), std::uint16_t{0});
  return mask_.empty() ? 0.0 : 1.0 - static_cast<double>(empty) / static_cast<double>(mask_.size());
}

hal::Result<void> save_scan_mask(const std::string& path, const hal::CameraModel& camera,
                                 const std::vector<std::uint16_t>& mask) {
  return hal::write_png_depth(path, {camera.width_px, camera.height_px}, mask);
}

hal::Result<std::vector<std::uint16_t>> load_scan_mask(const std::string& path, const hal::CameraModel& camera) {
  const auto bytes = hal::read_file(path, kMaxMaskFile_bytes);
  if (!bytes) return bytes.error();
  std::vector<std::uint16_t> mask(camera.pixel_count());
  hal::PngReader reader;
  if (const auto decoded = reader.decode_depth(bytes.value(), path, {camera.width_px, camera.height_px}, mask);
      !decoded) {
    return decoded.error();
  }
  return mask;
}

}  // namespace g3d::mapper
