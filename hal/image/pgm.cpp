// SPDX-License-Identifier: Apache-2.0
// Format: netpbm's pgm(5). Header tokens are separated by white space or comments, one white space ends the header.
#include "hal/image/pgm.hpp"

#include <algorithm>
#include <cstddef>

#include "hal/image/file_bytes.hpp"

namespace g3d::hal {
namespace {

// A header with comments is still small; what follows is one byte per pixel.
constexpr std::size_t kMaxPgmHeader_bytes = 64 * 1024;
constexpr std::size_t kMaxPgmFile_bytes =
    kMaxPgmHeader_bytes + std::size_t{kMaxPgmSide_px} * std::size_t{kMaxPgmSide_px};

bool is_space(std::uint8_t c) { return c == ' ' || (c >= '\t' && c <= '\r'); }
bool is_digit(std::uint8_t c) { return c >= '0' && c <= '9'; }

struct HeaderReader {
  std::span<const std::uint8_t> file;
  std::string_view name;
  std::size_t at = 0;

  [[nodiscard]] bool ended() const { return at >= file.size() || at >= kMaxPgmHeader_bytes; }

  Error error(Reason reason, std::string_view what) const {
    return {reason, fmt::format("{}: byte {}: {}; expected a binary PGM: P5, width, height, up to 255, pixels", name,
                                at, what)};
  }

  void skip_space_and_comments() {
    while (!ended() && (is_space(file[at]) || file[at] == '#')) {
      if (file[at] == '#') {
        while (!ended() && file[at] != '\n' && file[at] != '\r') ++at;
      } else {
        ++at;
      }
    }
  }

  Result<int> number(int min, int max, std::string_view what) {
    skip_space_and_comments();
    if (ended()) return error(Reason::truncated, fmt::format("ends before the {}", what));
    if (!is_digit(file[at])) return error(Reason::malformed, fmt::format("the {} is not a number", what));
    int value = 0;
    while (!ended() && is_digit(file[at])) {
      value = value * 10 + (file[at] - '0');
      if (value > max) return error(Reason::too_large, fmt::format("the {} is above {}", what, max));
      ++at;
    }
    if (value < min) return error(Reason::out_of_range, fmt::format("the {} is below {}", what, min));
    return value;
  }
};

}  // namespace

Result<GreyImage> parse_pgm(std::span<const std::uint8_t> file, std::string_view name) {
  HeaderReader header{file, name};
  if (file.size() < 2 || file[0] != 'P' || file[1] != '5') {
    return header.error(Reason::unsupported, "does not begin with P5");
  }
  header.at = 2;
  const Result<int> width_px = header.number(1, kMaxPgmSide_px, "width");
  if (!width_px) return width_px.error();
  const Result<int> height_px = header.number(1, kMaxPgmSide_px, "height");
  if (!height_px) return height_px.error();
  const Result<int> max_value = header.number(1, 255, "largest value");
  if (!max_value) return max_value.error();
  if (header.ended()) return header.error(Reason::truncated, "ends before the pixels");
  if (!is_space(file[header.at])) return header.error(Reason::malformed, "no white space before the pixels");
  ++header.at;

  GreyImage image{{width_px.value(), height_px.value()}, max_value.value(), {}};
  const std::span<const std::uint8_t> rest = file.subspan(header.at);
  if (rest.size() < image.size.pixel_count()) {
    return header.error(Reason::truncated,
                        fmt::format("{} bytes of pixels are missing", image.size.pixel_count() - rest.size()));
  }
  const auto pixels = rest.first(image.size.pixel_count());
  const auto above = std::find_if(pixels.begin(), pixels.end(), [&](std::uint8_t v) { return v > image.max_value; });
  if (above != pixels.end()) {
    header.at += static_cast<std::size_t>(above - pixels.begin());
    return header.error(Reason::out_of_range, "a pixel is above the largest value");
  }
  image.pixels.assign(pixels.begin(), pixels.end());
  return image;
}

Result<GreyImage> read_pgm(const std::string& path) {
  const Result<std::vector<std::uint8_t>> file = read_file(path, kMaxPgmFile_bytes);
  if (!file) return file.error();
  return parse_pgm(file.value(), path);
}

Result<std::vector<std::uint8_t>> encode_pgm(const GreyImage& image, std::string_view comment) {
  const ImageSize size = image.size;
  if (size.width_px < 1 || size.height_px < 1 || size.width_px > kMaxPgmSide_px || size.height_px > kMaxPgmSide_px ||
      image.pixels.size() != size.pixel_count() || image.max_value < 1 || image.max_value > 255 ||
      comment.find_first_of("\r\n") != std::string_view::npos) {
    return Error{Reason::bad_usage, fmt::format("PGM of {}x{} pixels: size, buffer length, largest value or comment "
                                                "is impossible",
                                                size.width_px, size.height_px)};
  }
  const std::string header = fmt::format("P5\n{}{}{}{} {}\n{}\n", comment.empty() ? "" : "# ", comment,
                                         comment.empty() ? "" : "\n", size.width_px, size.height_px, image.max_value);
  std::vector<std::uint8_t> out;
  out.reserve(header.size() + image.pixels.size());
  out.insert(out.end(), header.begin(), header.end());
  out.insert(out.end(), image.pixels.begin(), image.pixels.end());
  return out;
}

Result<void> write_pgm(const std::string& path, const GreyImage& image, std::string_view comment) {
  const Result<std::vector<std::uint8_t>> encoded = encode_pgm(image, comment);
  if (!encoded) return Error{encoded.error().reason, path + ": " + encoded.error().text};
  return write_file_atomic(path, encoded.value());
}

}  // namespace g3d::hal
