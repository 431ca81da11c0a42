// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/frame_scanner.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>

namespace g3d::hal::kobuki {
namespace {

std::uint8_t xor_of(std::span<const std::uint8_t> bytes) {
  std::uint8_t sum = 0;
  for (const std::uint8_t byte : bytes) sum ^= byte;
  return sum;
}

}  // namespace

bool take_block(std::span<const std::uint8_t>& payload, Block& block) {
  if (payload.size() < 2 || payload.size() - 2 < payload[1]) return false;
  block = {payload[0], payload.subspan(2, payload[1])};
  payload = payload.subspan(2 + block.data.size());
  return true;
}

std::size_t FrameScanner::append(std::span<const std::uint8_t> bytes) {
  if (begin_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  const std::size_t taken = std::min(bytes.size(), buffer_.size() - end_);
  if (taken > 0) std::memcpy(buffer_.data() + end_, bytes.data(), taken);
  end_ += taken;
  return taken;
}

bool FrameScanner::find_header(RejectCounts& rejects) {
  const std::size_t from = begin_;
  const auto is_header = [&](std::size_t at) {
    return buffer_[at] == kFrameHeader0 && (at + 1 == end_ || buffer_[at + 1] == kFrameHeader1);
  };
  while (begin_ < end_ && !is_header(begin_)) ++begin_;
  rejects.skipped_bytes += begin_ - from;
  return begin_ < end_;
}

FrameScanner::Verdict FrameScanner::check_frame(Reject& reason) {
  const std::size_t have_bytes = end_ - begin_;
  if (have_bytes < 3) return Verdict::unfinished;
  const std::uint8_t* const frame = buffer_.data() + begin_;
  const std::size_t payload_bytes = frame[2];
  if (payload_bytes < kMinPayload_bytes || payload_bytes > kMaxPayload_bytes) {
    reason = Reject::bad_length;
    return Verdict::wrong;
  }
  while (checked_bytes_ < payload_bytes) {
    if (checked_bytes_ + 2 > payload_bytes) {
      reason = Reject::block_overruns;
      return Verdict::wrong;
    }
    if (3 + checked_bytes_ + 2 > have_bytes) return Verdict::unfinished;
    const std::size_t size_bytes = frame[3 + checked_bytes_ + 1];
    if (!size_is_right_(frame[3 + checked_bytes_], size_bytes)) {
      reason = Reject::wrong_block_size;
      return Verdict::wrong;
    }
    checked_bytes_ += 2 + size_bytes;
    if (checked_bytes_ > payload_bytes) {
      reason = Reject::block_overruns;
      return Verdict::wrong;
    }
  }
  if (have_bytes < payload_bytes + 4) return Verdict::unfinished;
  if (xor_of({frame + 2, payload_bytes + 2}) != 0) {
    reason = Reject::bad_checksum;
    return Verdict::wrong;
  }
  return Verdict::whole;
}

std::span<const std::uint8_t> FrameScanner::next(RejectCounts& rejects) {
  while (find_header(rejects)) {
    Reject reason{};
    const Verdict verdict = check_frame(reason);
    if (verdict == Verdict::unfinished) return {};
    checked_bytes_ = 0;
    if (verdict == Verdict::whole) {
      const std::span payload(buffer_.data() + begin_ + 3, buffer_[begin_ + 2]);
      begin_ += payload.size() + 4;
      ++rejects.accepted_frames;
      return payload;
    }
    rejects.count(reason);
    ++begin_;
    ++rejects.skipped_bytes;
  }
  return {};
}

void FrameWriter::begin_block(std::uint8_t id, std::uint8_t size_bytes) {
  put_u8(id);
  put_u8(size_bytes);
}

void FrameWriter::put_u16(std::uint16_t value) {
  put_u8(static_cast<std::uint8_t>(value & 0xFF));
  put_u8(static_cast<std::uint8_t>(value >> 8));
}

void FrameWriter::put_u32(std::uint32_t value) {
  put_u16(static_cast<std::uint16_t>(value & 0xFFFF));
  put_u16(static_cast<std::uint16_t>(value >> 16));
}

std::size_t FrameWriter::finish() {
  assert(end_ + 1 <= out_.size() && end_ - 3 <= kMaxPayload_bytes && "room for the whole frame");
  out_[0] = kFrameHeader0;
  out_[1] = kFrameHeader1;
  out_[2] = static_cast<std::uint8_t>(end_ - 3);
  out_[end_] = xor_of(out_.subspan(2, end_ - 2));
  return end_ + 1;
}

}  // namespace g3d::hal::kobuki
