// SPDX-License-Identifier: Apache-2.0
#include "hal/kinect/oni_records.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>

namespace g3d::hal::kinect {
namespace {

constexpr std::uint32_t kRecordMagic = 0x0052494E;
constexpr std::uint32_t kMostFields_bytes = 1U << 16;  // the largest property that we know has 20 kB

static_assert(std::endian::native == std::endian::little, "numbers are read as they lie there");

}  // namespace

Bytes OniFields::take(std::size_t bytes) {
  ok = ok && rest.size() >= bytes;
  if (!ok) return {};
  const Bytes taken = rest.first(bytes);
  rest = rest.subspan(bytes);
  return taken;
}

std::string_view OniFields::text(std::size_t most_bytes) {
  const auto bytes = number<std::uint32_t>();
  ok = ok && bytes >= 1 && bytes <= most_bytes;
  const Bytes taken = ok ? take(bytes) : Bytes{};
  if (!ok) return {};
  const std::string_view text(reinterpret_cast<const char*>(taken.data()), taken.size());
  ok = text.find('\0') == text.size() - 1;
  return text.substr(0, text.size() - 1);
}

Error OniRecords::error(std::size_t at, Reason reason, std::string_view what) const {
  return {reason, fmt::format("{}: byte {}: {}", name_, at, what)};
}

Error OniRecords::cut(std::size_t at) const {
  return error(
      at, Reason::truncated,
      fmt::format("the file ends within what begins here: it has {} bytes; its recording was cut off, or copied "
                  "in part",
                  file_.size()));
}

Result<void> OniRecords::read_header() {
  if (file_.size() < kFileHeader_bytes) return cut(0);
  if (std::memcmp(file_.data(), "NI10", 4) != 0) {
    return error(0, Reason::malformed, "does not begin with NI10, so it is no .oni recording");
  }
  const std::array<std::uint32_t, 4> version{file_[4], file_[5], read_at<std::uint16_t>(file_, 6),
                                             read_at<std::uint32_t>(file_, 8)};
  constexpr std::array<std::uint32_t, 4> kOldest{1, 0, 0, 5}, kWide{1, 0, 1, 0};
  if (version < kOldest || version > kWide) {
    return error(4, Reason::unsupported,
                 fmt::format("format version {} is none of 1.0.0.5 to 1.0.1.0", fmt::join(version, ".")));
  }
  header_.is_wide = version == kWide;
  header_.last_stamp_us = read_at<std::uint64_t>(file_, 12);
  header_.highest_node = read_at<std::uint32_t>(file_, 20);
  return {};
}

Result<OniRecord> OniRecords::read(std::size_t at) const {
  if (at > file_.size() || file_.size() - at < head_bytes()) return cut(std::min(at, file_.size()));
  if (read_at<std::uint32_t>(file_, at) != kRecordMagic) {
    return error(at, Reason::malformed, "no record begins here; the file is damaged");
  }
  OniRecord record;
  record.at = at;
  record.type = read_at<std::uint32_t>(file_, at + 4);
  record.node = read_at<std::uint32_t>(file_, at + 8);
  const auto fields = read_at<std::uint32_t>(file_, at + 12), payload = read_at<std::uint32_t>(file_, at + 16);
  if (fields < head_bytes() || fields > kMostFields_bytes) {
    return error(at + 12, Reason::malformed, fmt::format("a record of {} bytes", fields));
  }
  if (payload > kPlayerBuffer_bytes) {
    return error(at + 16, Reason::too_large, fmt::format("a record with {} bytes of data", payload));
  }
  if (file_.size() - at < std::size_t{fields} + payload) return cut(at);
  record.fields = file_.subspan(at + head_bytes(), fields - head_bytes());
  record.payload = file_.subspan(at + fields, payload);
  return record;
}

}  // namespace g3d::hal::kinect
