// SPDX-License-Identifier: Apache-2.0
// libpng reports errors by longjmp. So that no destructor is ever jumped over, everything between setjmp and the calls
// that may jump lives in `Decoder`, and the functions in between hold plain values only.
#include "hal/image/png_reader.hpp"

#include <png.h>

#include <bit>
#include <cassert>
#include <csetjmp>
#include <cstring>
#include <string>

#include "hal/messages.hpp"

namespace g3d::hal {
namespace {

// libpng's structures, zlib's window and four rows of the widest image (16-bit RGBA) take less than 300 kB.
constexpr std::size_t kArena_bytes = 1 << 20;
constexpr std::size_t kMaxChunk_bytes = 256 * 1024;
constexpr std::size_t kMaxMessage_bytes = 128;

// The header's place is fixed, and libpng calls a too large image only "invalid".
bool announces_too_large(std::span<const std::uint8_t> file) {
  constexpr std::size_t kWidthAt_bytes = 16;
  if (file.size() < kWidthAt_bytes + 8 || png_sig_cmp(file.data(), 0, 8) != 0) return false;
  const png_uint_32 width_px = png_get_uint_32(file.data() + kWidthAt_bytes);
  const png_uint_32 height_px = png_get_uint_32(file.data() + kWidthAt_bytes + 4);
  return width_px > png_uint_32{kMaxImageSide_px} || height_px > png_uint_32{kMaxImageSide_px};
}

enum class Target { size_only, depth16, rgb8 };

}  // namespace

struct PngReader::Decoder {
  // The arena: bump allocation, all given back when the next image begins.
  std::unique_ptr<std::byte[]> arena = std::make_unique<std::byte[]>(kArena_bytes);
  std::size_t arena_used_bytes = 0;

  // The file being read.
  std::span<const std::uint8_t> file;
  std::size_t position_bytes = 0;

  // What came of it.
  ImageSize size;
  Reason reason = Reason::malformed;
  char message[kMaxMessage_bytes] = {};

  void begin(std::span<const std::uint8_t> bytes) {
    arena_used_bytes = 0;
    file = bytes;
    position_bytes = 0;
    size = {};
    reason = Reason::malformed;
    message[0] = '\0';
  }

  void explain(Reason why, const char* text) {
    reason = why;
    std::strncpy(message, text, kMaxMessage_bytes - 1);
    message[kMaxMessage_bytes - 1] = '\0';
  }

  static void* allocate(png_structp png, png_alloc_size_t size_bytes) {
    auto* self = static_cast<Decoder*>(png_get_mem_ptr(png));
    constexpr std::size_t kAlign_bytes = alignof(std::max_align_t);
    if (size_bytes > kArena_bytes) return nullptr;
    const std::size_t rounded_bytes = (size_bytes + kAlign_bytes - 1) / kAlign_bytes * kAlign_bytes;
    if (rounded_bytes > kArena_bytes - self->arena_used_bytes) return nullptr;
    void* const memory = self->arena.get() + self->arena_used_bytes;
    self->arena_used_bytes += rounded_bytes;
    return memory;
  }
  static void release(png_structp, png_voidp) {}

  static void on_read(png_structp png, png_bytep to, std::size_t size_bytes) {
    auto* self = static_cast<Decoder*>(png_get_io_ptr(png));
    if (size_bytes > self->file.size() - self->position_bytes) {
      self->reason = Reason::truncated;
      png_error(png, "ends too early");
    }
    std::memcpy(to, self->file.data() + self->position_bytes, size_bytes);
    self->position_bytes += size_bytes;
  }

  [[noreturn]] static void on_error(png_structp png, png_const_charp text) {
    auto* self = static_cast<Decoder*>(png_get_error_ptr(png));
    self->explain(self->reason, text);
    png_longjmp(png, 1);
  }
  static void on_warning(png_structp, png_const_charp) {}

  bool decode(Target target, ImageSize expected, std::uint8_t* pixels);
  bool read_header(png_structp png, png_infop info, Target target, ImageSize expected);
  static void read_rows(png_structp png, png_infop info, Target target, ImageSize expected, std::uint8_t* pixels);
};

bool PngReader::Decoder::read_header(png_structp png, png_infop info, Target target, ImageSize expected) {
  png_set_user_limits(png, kMaxImageSide_px, kMaxImageSide_px);
  png_set_chunk_malloc_max(png, kMaxChunk_bytes);
  // Negative: everything but header, palette, transparency and pixels. Profiles and texts could only fill the arena.
  png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
  png_set_read_fn(png, this, on_read);
  png_read_info(png, info);
  size = {static_cast<int>(png_get_image_width(png, info)), static_cast<int>(png_get_image_height(png, info))};
  if (target == Target::size_only) return true;
  if (target == Target::depth16 &&
      (png_get_bit_depth(png, info) != 16 || png_get_color_type(png, info) != PNG_COLOR_TYPE_GRAY)) {
    explain(Reason::unsupported, "is not a 16-bit grey image, as depth must be");
    return false;
  }
  if (size != expected) {
    reason = Reason::out_of_range;
    return false;
  }
  return true;
}

void PngReader::Decoder::read_rows(png_structp png, png_infop info, Target target, ImageSize expected,
                                   std::uint8_t* pixels) {
  const auto width_px = static_cast<std::size_t>(expected.width_px);
  std::size_t row_bytes = 2 * width_px;
  if (target == Target::depth16) {
    if constexpr (std::endian::native == std::endian::little) png_set_swap(png);
  } else {
    row_bytes = 3 * width_px;
    png_set_expand(png);  // palette and 1, 2, 4-bit grey to 8 bits
    png_set_scale_16(png);
    png_set_strip_alpha(png);
    png_set_gray_to_rgb(png);
  }
  const int passes = png_set_interlace_handling(png);
  png_read_update_info(png, info);
  if (png_get_rowbytes(png, info) != row_bytes) png_error(png, "has rows of an unexpected length");
  for (int pass = 0; pass < passes; ++pass) {
    std::uint8_t* row = pixels;
    for (int y = 0; y < expected.height_px; ++y, row += row_bytes) png_read_row(png, row, nullptr);
  }
  png_read_end(png, nullptr);
}

bool PngReader::Decoder::decode(Target target, ImageSize expected, std::uint8_t* pixels) {
  if (announces_too_large(file)) {
    explain(Reason::too_large, "announces a side of more than 2048 pixels");
    return false;
  }
  png_structp png =
      png_create_read_struct_2(PNG_LIBPNG_VER_STRING, this, on_error, on_warning, this, allocate, release);
  png_infop info = png == nullptr ? nullptr : png_create_info_struct(png);
  if (info == nullptr) {
    explain(Reason::no_capacity, "cannot start libpng");
    return false;
  }
  // Nothing to destroy on either way out: libpng's memory is the arena, and the next image empties that.
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  if (!read_header(png, info, target, expected)) return false;
  if (target != Target::size_only) read_rows(png, info, target, expected, pixels);
  return true;
}

namespace {

Error unusable_png(std::string_view name, Reason reason, const char* message) {
  return {reason, fmt::format("{}: not a usable PNG: {}; copy or record it again", name, message)};
}

}  // namespace

PngReader::PngReader() : decoder_(std::make_unique<Decoder>()) {}
PngReader::~PngReader() = default;

Result<ImageSize> PngReader::size(std::span<const std::uint8_t> file, std::string_view name) {
  decoder_->begin(file);
  if (!decoder_->decode(Target::size_only, {}, nullptr)) return unusable_png(name, decoder_->reason, decoder_->message);
  return decoder_->size;
}

Result<void> PngReader::decode_depth(std::span<const std::uint8_t> file, std::string_view name, ImageSize expected,
                                     std::span<std::uint16_t> depth) {
  assert(depth.size() == expected.pixel_count());
  decoder_->begin(file);
  if (decoder_->decode(Target::depth16, expected, reinterpret_cast<std::uint8_t*>(depth.data()))) return {};
  if (decoder_->reason == Reason::out_of_range) return wrong_size_error(name, decoder_->size, expected);
  return unusable_png(name, decoder_->reason, decoder_->message);
}

Result<void> PngReader::decode_rgb(std::span<const std::uint8_t> file, std::string_view name, ImageSize expected,
                                   std::span<std::uint8_t> rgb) {
  assert(rgb.size() == 3 * expected.pixel_count());
  decoder_->begin(file);
  if (decoder_->decode(Target::rgb8, expected, rgb.data())) return {};
  if (decoder_->reason == Reason::out_of_range) return wrong_size_error(name, decoder_->size, expected);
  return unusable_png(name, decoder_->reason, decoder_->message);
}

}  // namespace g3d::hal
