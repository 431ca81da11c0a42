// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/kobuki_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "hal/image/file_bytes.hpp"
#include "hal/replay/decimal.hpp"

namespace g3d::hal {
namespace {

using Bytes = std::span<const std::uint8_t>;
constexpr std::size_t kHeader_bytes = 10;
constexpr TimeNs kMaxTime_ns = kMaxStamp_s * 1'000'000'000;

TimeNs time_of(Bytes header) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < 8; ++i) value |= std::uint64_t{header[i]} << (8 * i);
  return static_cast<TimeNs>(value);
}

std::size_t size_of(Bytes header) { return header[8] | std::size_t{header[9]} << 8; }

/// The record at the beginning of `rest`, if all of it is there.
std::optional<LineRecord> first_of(Bytes rest) {
  if (rest.size() < kHeader_bytes || rest.size() - kHeader_bytes < size_of(rest)) return std::nullopt;
  return LineRecord{time_of(rest), rest.subspan(kHeader_bytes, size_of(rest))};
}

}  // namespace

Result<KobukiLog> KobukiLog::open(const std::string& path) {
  Result<std::vector<std::uint8_t>> file = read_file(path, kMaxKobukiLog_bytes);
  if (!file) return file.error();
  return parse(std::move(file).value(), path);
}

Result<KobukiLog> KobukiLog::parse(std::vector<std::uint8_t> file, std::string_view name) {
  KobukiLog log;
  Bytes rest = file;
  TimeNs last_ns = -kMaxTime_ns;
  while (const std::optional<LineRecord> record = first_of(rest)) {
    const std::size_t at = file.size() - rest.size();
    if (record->t_ns < -kMaxTime_ns || record->t_ns > kMaxTime_ns) {
      return Error{Reason::out_of_range, fmt::format("{}: byte {}: time {} ns lies centuries away; is it a kobuki.bin?",
                                                     name, at, record->t_ns)};
    }
    if (record->t_ns < last_ns) {
      return Error{Reason::malformed, fmt::format("{}: byte {}: a record earlier than the one before; records must be "
                                                  "in the order of time",
                                                  name, at)};
    }
    if (record->bytes.empty()) {
      return Error{Reason::malformed,
                   fmt::format("{}: byte {}: a record without bytes; is it a kobuki.bin?", name, at)};
    }
    last_ns = record->t_ns;
    ++log.record_count_;
    rest = rest.subspan(kHeader_bytes + record->bytes.size());
  }
  log.torn_bytes_ = rest.size();
  file.resize(file.size() - rest.size());
  log.file_ = std::move(file);
  return log;
}

std::optional<LineRecord> KobukiLog::Cursor::peek() const { return first_of(rest_); }

void KobukiLog::Cursor::advance() {
  if (const std::optional<LineRecord> record = peek()) rest_ = rest_.subspan(kHeader_bytes + record->bytes.size());
}

void append_record(std::vector<std::uint8_t>& file, TimeNs t_ns, Bytes bytes) {
  while (!bytes.empty()) {
    const std::size_t size = std::min<std::size_t>(bytes.size(), std::numeric_limits<std::uint16_t>::max());
    for (std::size_t i = 0; i < 8; ++i) {
      file.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(t_ns) >> (8 * i)));
    }
    file.push_back(static_cast<std::uint8_t>(size & 0xFF));
    file.push_back(static_cast<std::uint8_t>(size >> 8));
    file.insert(file.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    bytes = bytes.subspan(size);
  }
}

}  // namespace g3d::hal
