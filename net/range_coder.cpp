// SPDX-License-Identifier: Apache-2.0
#include "net/range_coder.hpp"

namespace g3d::net {

int bytes_of_shortest(std::uint64_t low, std::uint64_t high, std::uint64_t& number) {
  if (low == 0) {
    number = 0;
    return 0;
  }
  for (int count = 1; count < 8; ++count) {
    const std::uint64_t below = (std::uint64_t{1} << (64 - 8 * count)) - 1;
    const std::uint64_t floor = high & ~below;
    if (floor < low) continue;
    number = (low & below) == 0 ? low : (low | below) + 1;
    return count;
  }
  number = low;
  return 8;
}

void RangeEncoder::open(std::span<std::uint8_t> out, std::uint8_t first_byte) {
  out_ = out;
  size_ = 0;
  low_ = static_cast<std::uint64_t>(first_byte) << 56;
  high_ = ~std::uint64_t{0};
  overrun_ = false;
}

void RangeEncoder::shift() {
  if (size_ < out_.size()) {
    out_[size_++] = static_cast<std::uint8_t>(low_ >> 56);
  } else {
    overrun_ = true;
  }
  low_ <<= 8;
  high_ = high_ << 8 | 0xFFU;
}

std::size_t RangeEncoder::finish() {
  std::uint64_t number = 0;
  const int count = bytes_of_shortest(low_, high_, number);
  for (int i = 0; i < count; ++i) {
    if (size_ == out_.size()) overrun_ = true;
    if (overrun_) return 0;
    out_[size_++] = static_cast<std::uint8_t>(number >> (56 - 8 * i));
  }
  if (overrun_) return 0;
  while (size_ > 0 && out_[size_ - 1] == 0) --size_;
  return size_;
}

void RangeDecoder::open(ByteSpan bytes, std::uint8_t first_byte) {
  bytes_ = bytes;
  next_ = 0;
  shifted_ = 0;
  low_ = static_cast<std::uint64_t>(first_byte) << 56;
  high_ = ~std::uint64_t{0};
  value_ = 0;
  for (int i = 0; i < 8; ++i) {
    value_ = value_ << 8 | (next_ < bytes_.size() ? bytes_[next_] : 0U);
    ++next_;
  }
}

void RangeDecoder::shift() {
  value_ = value_ << 8 | (next_ < bytes_.size() ? bytes_[next_] : 0U);
  ++next_;
  ++shifted_;
  low_ <<= 8;
  high_ = high_ << 8 | 0xFFU;
}

bool RangeDecoder::at_end() const {
  std::uint64_t number = 0;
  const int count = bytes_of_shortest(low_, high_, number);
  const std::size_t size = shifted_ + static_cast<std::size_t>(count);
  if (number != value_) return false;
  // What the interval has settled is in the bytes as it stands; zeros at the end were not sent.
  if (bytes_.size() > size) return false;
  return bytes_.empty() || bytes_.back() != 0;
}

}  // namespace g3d::net
