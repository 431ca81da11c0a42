// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/replay_line.hpp"

#include <algorithm>

namespace g3d::hal {

std::size_t ReplayLine::read(std::span<std::uint8_t> into) {
  std::size_t done = 0;
  while (done < into.size()) {
    const std::optional<LineRecord> record = cursor_.peek();
    if (!record || record->t_ns > clock_.now()) break;
    const auto left = record->bytes.subspan(taken_bytes_);
    const std::size_t count = std::min(left.size(), into.size() - done);
    std::copy_n(left.begin(), count, into.begin() + static_cast<std::ptrdiff_t>(done));
    done += count;
    taken_bytes_ += count;
    if (taken_bytes_ == record->bytes.size()) {
      cursor_.advance();
      taken_bytes_ = 0;
    }
  }
  return done;
}

bool ReplayLine::write(std::span<const std::uint8_t> bytes) {
  if (state() == LineState::lost) return false;
  swallowed_bytes_ += bytes.size();
  return true;
}

LineState ReplayLine::state() const { return cursor_.peek() ? LineState::up : LineState::lost; }

std::optional<TimeNs> ReplayLine::next_ns() const {
  const std::optional<LineRecord> record = cursor_.peek();
  return record ? std::optional(record->t_ns) : std::nullopt;
}

}  // namespace g3d::hal
