// SPDX-License-Identifier: Apache-2.0
#include "hal/record/packed_image.hpp"

#include <fmt/format.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <new>

namespace g3d::hal {
namespace {

static_assert(std::endian::native == std::endian::little, "pixels are summed up as they lie in memory");

constexpr std::string_view kImageMagic = "g3dimage";
constexpr std::uint16_t kImageVersion = 1;
constexpr int kDepthKind = 1;
constexpr int kColourKind = 2;
constexpr std::size_t kImageHeader_bytes = 24;
// The fastest level: recording shares the processor with driving.
constexpr int kFastest = 1;

std::size_t bytes_of(ImageSize size, int kind) { return (kind == kDepthKind ? 2 : 3) * size.pixel_count(); }

std::uint32_t checksum(std::span<const std::uint8_t> bytes) {
  return static_cast<std::uint32_t>(::crc32_z(0, bytes.data(), bytes.size()));
}

template <typename T>
void put_at(std::vector<std::uint8_t>& file, std::size_t at, T value) {
  std::memcpy(file.data() + at, &value, sizeof value);
}

template <typename T>
T get_at(std::span<const std::uint8_t> file, std::size_t at) {
  T value;
  std::memcpy(&value, file.data() + at, sizeof value);
  return value;
}

/// Of 16-bit values along each row: all low bytes, then all high ones.
void depth_differences(ImageSize size, const std::uint16_t* depth, std::uint8_t* out) {
  const auto width = static_cast<std::size_t>(size.width_px);
  std::uint8_t* const low = out;
  std::uint8_t* const high = out + size.pixel_count();
  for (std::size_t row = 0; row < size.pixel_count(); row += width) {
    std::uint16_t before = 0;
    for (std::size_t i = row; i < row + width; ++i) {
      const auto difference = static_cast<std::uint16_t>(depth[i] - before);
      // Small ones of either sign have few high bytes then.
      const auto folded = static_cast<std::uint16_t>((difference << 1) ^ ((difference & 0x8000U) != 0 ? 0xFFFFU : 0U));
      before = depth[i];
      low[i] = static_cast<std::uint8_t>(folded);
      high[i] = static_cast<std::uint8_t>(folded >> 8);
    }
  }
}

void add_depth(ImageSize size, const std::uint8_t* differences, std::uint16_t* depth) {
  const auto width = static_cast<std::size_t>(size.width_px);
  const std::uint8_t* const low = differences;
  const std::uint8_t* const high = differences + size.pixel_count();
  for (std::size_t row = 0; row < size.pixel_count(); row += width) {
    std::uint16_t value = 0;
    for (std::size_t i = row; i < row + width; ++i) {
      const auto folded = static_cast<std::uint16_t>(low[i] | high[i] << 8);
      const auto difference = static_cast<std::uint16_t>((folded >> 1) ^ ((folded & 1U) != 0 ? 0xFFFFU : 0U));
      value = static_cast<std::uint16_t>(value + difference);
      depth[i] = value;
    }
  }
}

void colour_differences(ImageSize size, const std::uint8_t* rgb, std::uint8_t* out) {
  const std::size_t row_bytes = 3 * static_cast<std::size_t>(size.width_px);
  for (std::size_t row = 0; row < 3 * size.pixel_count(); row += row_bytes) {
    std::memcpy(out + row, rgb + row, 3);
    for (std::size_t i = row + 3; i < row + row_bytes; ++i) out[i] = static_cast<std::uint8_t>(rgb[i] - rgb[i - 3]);
  }
}

void add_colours(ImageSize size, const std::uint8_t* differences, std::uint8_t* rgb) {
  const std::size_t row_bytes = 3 * static_cast<std::size_t>(size.width_px);
  for (std::size_t row = 0; row < 3 * size.pixel_count(); row += row_bytes) {
    std::memcpy(rgb + row, differences + row, 3);
    for (std::size_t i = row + 3; i < row + row_bytes; ++i) {
      rgb[i] = static_cast<std::uint8_t>(differences[i] + rgb[i - 3]);
    }
  }
}

Error image_error(Reason reason, std::string_view name, std::string_view what) {
  return {reason, fmt::format("{}: {}", name, what)};
}

}  // namespace

bool is_packed_image(std::span<const std::uint8_t> file) {
  return file.size() >= kImageMagic.size() && std::equal(kImageMagic.begin(), kImageMagic.end(), file.begin());
}

ImagePacker::ImagePacker(ImageSize largest)
    : zstd_(ZSTD_createCCtx()),
      differences_(3 * largest.pixel_count()),
      file_(kImageHeader_bytes + ZSTD_compressBound(3 * largest.pixel_count())) {
  if (zstd_ == nullptr) throw std::bad_alloc();
  // Now, and not in the middle of a drive, zstd takes its memory.
  const ImageSize size = largest;
  (void)pack(size, kColourKind, differences_);
}

ImagePacker::~ImagePacker() { ZSTD_freeCCtx(zstd_); }

std::span<const std::uint8_t> ImagePacker::pack_depth(ImageSize size, std::span<const std::uint16_t> depth) {
  depth_differences(size, depth.data(), differences_.data());
  return pack(size, kDepthKind, {reinterpret_cast<const std::uint8_t*>(depth.data()), 2 * size.pixel_count()});
}

std::span<const std::uint8_t> ImagePacker::pack_rgb(ImageSize size, std::span<const std::uint8_t> rgb) {
  colour_differences(size, rgb.data(), differences_.data());
  return pack(size, kColourKind, rgb.first(3 * size.pixel_count()));
}

std::span<const std::uint8_t> ImagePacker::pack(ImageSize size, int kind, std::span<const std::uint8_t> pixels) {
  std::memcpy(file_.data(), kImageMagic.data(), kImageMagic.size());
  put_at(file_, 8, kImageVersion);
  put_at(file_, 10, static_cast<std::uint16_t>(kind));
  put_at(file_, 12, static_cast<std::uint16_t>(size.width_px));
  put_at(file_, 14, static_cast<std::uint16_t>(size.height_px));
  const std::size_t packed_bytes =
      ZSTD_compressCCtx(zstd_, file_.data() + kImageHeader_bytes, file_.size() - kImageHeader_bytes,
                        differences_.data(), bytes_of(size, kind), kFastest);
  if (ZSTD_isError(packed_bytes) != 0) return {};
  put_at(file_, 16, static_cast<std::uint32_t>(packed_bytes));
  put_at(file_, 20, checksum(pixels));
  return std::span(file_).first(kImageHeader_bytes + packed_bytes);
}

ImageUnpacker::ImageUnpacker() : zstd_(ZSTD_createDCtx()) {
  if (zstd_ == nullptr) throw std::bad_alloc();
}

ImageUnpacker::~ImageUnpacker() { ZSTD_freeDCtx(zstd_); }

/// The checksum that the pixels must have; what they come from is in differences_.
Result<std::uint32_t> ImageUnpacker::unpack(std::span<const std::uint8_t> file, std::string_view name, int kind,
                                            ImageSize expected) {
  if (!is_packed_image(file)) return image_error(Reason::malformed, name, "is no packed image");
  if (file.size() < kImageHeader_bytes) return image_error(Reason::truncated, name, "ends within its header");
  if (get_at<std::uint16_t>(file, 8) != kImageVersion || get_at<std::uint16_t>(file, 10) != kind) {
    return image_error(Reason::unsupported, name, "is of another version, or another kind of image");
  }
  const int width_px = get_at<std::uint16_t>(file, 12), height_px = get_at<std::uint16_t>(file, 14);
  if (width_px != expected.width_px || height_px != expected.height_px) {
    return image_error(Reason::out_of_range, name,
                       fmt::format("is {}x{} pixels, but the camera has {}x{}", width_px, height_px, expected.width_px,
                                   expected.height_px));
  }
  const std::span<const std::uint8_t> packed = file.subspan(kImageHeader_bytes);
  const std::size_t announced = get_at<std::uint32_t>(file, 16);
  if (packed.size() < announced) return image_error(Reason::truncated, name, "ends before its last pixel");
  if (packed.size() > announced) return image_error(Reason::malformed, name, "goes on behind its last pixel");
  const std::size_t wanted = bytes_of(expected, kind);
  if (differences_.size() < wanted) differences_.resize(wanted);
  const std::size_t got = ZSTD_decompressDCtx(zstd_, differences_.data(), wanted, packed.data(), packed.size());
  if (ZSTD_isError(got) != 0 || got != wanted) return image_error(Reason::malformed, name, "cannot be unpacked");
  return get_at<std::uint32_t>(file, 20);
}

Result<void> ImageUnpacker::unpack_depth(std::span<const std::uint8_t> file, std::string_view name, ImageSize expected,
                                         std::span<std::uint16_t> depth) {
  const auto sum = unpack(file, name, kDepthKind, expected);
  if (!sum) return sum.error();
  add_depth(expected, differences_.data(), depth.data());
  if (checksum({reinterpret_cast<const std::uint8_t*>(depth.data()), 2 * expected.pixel_count()}) != sum.value()) {
    return image_error(Reason::bad_checksum, name, "is not what was recorded; the disk, or a copy, has spoiled it");
  }
  return {};
}

Result<void> ImageUnpacker::unpack_rgb(std::span<const std::uint8_t> file, std::string_view name, ImageSize expected,
                                       std::span<std::uint8_t> rgb) {
  const auto sum = unpack(file, name, kColourKind, expected);
  if (!sum) return sum.error();
  add_colours(expected, differences_.data(), rgb.data());
  if (checksum(rgb.first(3 * expected.pixel_count())) != sum.value()) {
    return image_error(Reason::bad_checksum, name, "is not what was recorded; the disk, or a copy, has spoiled it");
  }
  return {};
}

}  // namespace g3d::hal
