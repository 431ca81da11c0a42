// SPDX-License-Identifier: Apache-2.0
#include "net/wire_parts.hpp"

namespace g3d::net {
namespace {

MessageFault take_ranges(mapper::ByteReader& in, VersionRanges& out) {
  Version upto = 0;
  std::uint64_t beyond = 0;
  if (!in.take_varint(upto) || !in.take_varint(beyond)) return MessageFault::truncated;
  if (upto > kMostVersion) return MessageFault::bad_range;
  if (beyond > VersionRanges::kMostBeyond) return MessageFault::too_many;
  out = VersionRanges(upto);
  for (; beyond > 0; --beyond) {
    std::uint64_t gap = 0;
    std::uint64_t length = 0;
    if (!in.take_varint(gap) || !in.take_varint(length)) return MessageFault::truncated;
    if (gap == 0 || length == 0 || gap > kMostVersion || length > kMostVersion) return MessageFault::bad_range;
    const VersionRange range{upto + gap, upto + gap + length};
    if (range.upto > kMostVersion) return MessageFault::bad_range;
    (void)out.add(range);
    upto = range.upto;
  }
  return MessageFault::none;
}

}  // namespace

bool WireWriter::put_position(const LayerPosition& position) {
  const std::size_t size_before = size_;
  put_layer_id(position.id);
  for (const VersionRanges& had : position.had) {
    put_varint(had.upto());
    put_varint(had.beyond().size());
    Version last = had.upto();
    for (const VersionRange& range : had.beyond()) {
      put_varint(range.after - last);
      put_varint(range.upto - range.after);
      last = range.upto;
    }
  }
  if (size_ <= kMostMessage_bytes) return true;
  size_ = size_before;
  return false;
}

MessageFault take_position(mapper::ByteReader& in, LayerPosition& position) {
  if (!take_layer_id(in, position.id)) return MessageFault::truncated;
  for (VersionRanges& had : position.had) {
    if (const MessageFault fault = take_ranges(in, had); fault != MessageFault::none) return fault;
  }
  return MessageFault::none;
}

}  // namespace g3d::net
