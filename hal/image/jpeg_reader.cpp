// SPDX-License-Identifier: Apache-2.0
// libjpeg reports errors by a callback that must not return; ours jumps back. So that no destructor is jumped over,
// everything between setjmp and the calls that may jump lives in `Decoder`.
#include "hal/image/jpeg_reader.hpp"

// jpeglib.h uses FILE and size_t without including them.
#include <cstddef>
#include <cstdio>
// clang-format off
#include <jpeglib.h>
#include <jerror.h>
// clang-format on

#include <cassert>
#include <csetjmp>
#include <cstring>

#include "hal/messages.hpp"

namespace g3d::hal {
namespace {

// Every scan of a progressive file touches the whole image: thousands of tiny ones would take minutes. Real encoders
// write about ten.
constexpr int kMaxScans = 64;
// Coefficients of the largest progressive image take 25 MB.
constexpr long kMaxMemory_bytes = 64L << 20;

// Warnings after which libjpeg goes on with invented pixels.
bool invents_pixels(int message_code) {
  return message_code == JWRN_JPEG_EOF || message_code == JWRN_HIT_MARKER || message_code == JWRN_HUFF_BAD_CODE ||
         message_code == JWRN_ARITH_BAD_CODE || message_code == JWRN_MUST_RESYNC;
}

}  // namespace

struct JpegReader::Decoder {
  jpeg_decompress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg_progress_mgr progress{};
  std::jmp_buf jump{};
  bool created = false;
  ImageSize size;
  Reason reason = Reason::malformed;
  char message[JMSG_LENGTH_MAX] = {};

  ~Decoder() {
    if (created) jpeg_destroy_decompress(&jpeg);
  }

  static Decoder& of(j_common_ptr common) { return *static_cast<Decoder*>(common->client_data); }

  [[noreturn]] static void on_error(j_common_ptr common) {
    Decoder& self = of(common);
    common->err->format_message(common, self.message);
    if (common->err->msg_code == JWRN_JPEG_EOF || common->err->msg_code == JERR_INPUT_EMPTY) {
      self.reason = Reason::truncated;
    }
    std::longjmp(self.jump, 1);
  }
  static void on_message(j_common_ptr common, int level) {
    if (level < 0 && invents_pixels(common->err->msg_code)) on_error(common);
  }
  static void on_progress(j_common_ptr common) {
    const auto* jpeg = reinterpret_cast<j_decompress_ptr>(common);
    if (jpeg->input_scan_number <= kMaxScans) return;
    of(common).refuse(Reason::too_large, "has too many scans");
    std::longjmp(of(common).jump, 1);
  }
  static void on_output(j_common_ptr) {}

  bool refuse(Reason why, const char* text) {
    reason = why;
    std::strncpy(message, text, sizeof(message) - 1);
    return false;
  }

  // Kept from image to image: libjpeg's permanent pool is allocated once.
  bool create() {
    jpeg.err = jpeg_std_error(&errors);
    errors.error_exit = on_error;
    errors.emit_message = on_message;
    errors.output_message = on_output;
    jpeg.client_data = this;
    if (setjmp(jump) != 0) return false;
    jpeg_create_decompress(&jpeg);
    created = true;
    progress.progress_monitor = on_progress;
    jpeg.progress = &progress;
    jpeg.mem->max_memory_to_use = kMaxMemory_bytes;
    return true;
  }

  bool read_header(std::span<const std::uint8_t> file);
  bool read_rows(std::uint8_t* rgb);
  bool decode(std::span<const std::uint8_t> file, ImageSize expected, std::uint8_t* rgb);
};

bool JpegReader::Decoder::read_header(std::span<const std::uint8_t> file) {
  if (file.empty()) return refuse(Reason::truncated, "is empty");
  jpeg_mem_src(&jpeg, file.data(), file.size());
  jpeg_read_header(&jpeg, TRUE);
  if (jpeg.image_width > static_cast<JDIMENSION>(kMaxImageSide_px) ||
      jpeg.image_height > static_cast<JDIMENSION>(kMaxImageSide_px)) {
    return refuse(Reason::too_large, "has a side of more than 2048 pixels");
  }
  size = {static_cast<int>(jpeg.image_width), static_cast<int>(jpeg.image_height)};
  return true;
}

bool JpegReader::Decoder::read_rows(std::uint8_t* rgb) {
  if (jpeg.jpeg_color_space != JCS_GRAYSCALE && jpeg.jpeg_color_space != JCS_YCbCr &&
      jpeg.jpeg_color_space != JCS_RGB) {
    return refuse(Reason::unsupported, "is neither grey nor RGB");
  }
  jpeg.out_color_space = JCS_RGB;
  jpeg.dct_method = JDCT_ISLOW;  // the exact one: the same pixels on every machine
  jpeg_start_decompress(&jpeg);
  const std::size_t row_bytes = 3 * static_cast<std::size_t>(jpeg.output_width);
  while (jpeg.output_scanline < jpeg.output_height) {
    JSAMPROW row = rgb + jpeg.output_scanline * row_bytes;
    jpeg_read_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_decompress(&jpeg);
  return true;
}

bool JpegReader::Decoder::decode(std::span<const std::uint8_t> file, ImageSize expected, std::uint8_t* rgb) {
  size = {};
  reason = Reason::malformed;
  if (!created && !create()) return false;
  bool good = false;
  if (setjmp(jump) == 0) {
    if (read_header(file)) {
      if (rgb == nullptr) {
        good = true;
      } else if (size != expected) {
        reason = Reason::out_of_range;
      } else {
        good = read_rows(rgb);
      }
    }
  } else {
    good = false;
  }
  jpeg_abort_decompress(&jpeg);  // ready for the next image; cannot fail
  return good;
}

namespace {

Error unusable_jpeg(std::string_view name, Reason reason, const char* message) {
  return {reason, fmt::format("{}: not a usable JPEG: {}; copy or record it again", name, message)};
}

}  // namespace

JpegReader::JpegReader() : decoder_(std::make_unique<Decoder>()) {}
JpegReader::~JpegReader() = default;

Result<ImageSize> JpegReader::size(std::span<const std::uint8_t> file, std::string_view name) {
  if (!decoder_->decode(file, {}, nullptr)) return unusable_jpeg(name, decoder_->reason, decoder_->message);
  return decoder_->size;
}

Result<void> JpegReader::decode_rgb(std::span<const std::uint8_t> file, std::string_view name, ImageSize expected,
                                    std::span<std::uint8_t> rgb) {
  assert(rgb.size() == 3 * expected.pixel_count());
  if (decoder_->decode(file, expected, rgb.data())) return {};
  if (decoder_->reason == Reason::out_of_range) return wrong_size_error(name, decoder_->size, expected);
  return unusable_jpeg(name, decoder_->reason, decoder_->message);
}

}  // namespace g3d::hal
