// SPDX-License-Identifier: Apache-2.0
#include "net/wire_parts.hpp"

namespace g3d::net {
namespace {

MessageFault take_beyond(mapper::ByteReader& in, VersionRanges& out) {
  std::uint64_t count = 0;
  if (!in.take_varint(count)) return MessageFault::truncated;
  if (count > VersionRanges::kMostBeyond) return MessageFault::too_many;
  if (count == 0) return MessageFault::bad_range;
  Version upto = out.upto();
  for (; count > 0; --count) {
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

MessageFault take_had(mapper::ByteReader& in, HadLanes& had) {
  std::uint8_t has_beyond = 0;
  if (!in.take(has_beyond)) return MessageFault::truncated;
  if (has_beyond >= 1U << kLanes) return MessageFault::bad_range;
  Version upto = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    std::uint64_t number = 0;
    if (!in.take_varint(number)) return MessageFault::truncated;
    upto = lane == 0 ? number : upto + from_zigzag(number);
    if (upto > kMostVersion) return MessageFault::bad_range;
    had[lane] = VersionRanges(upto);
  }
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if ((has_beyond & (1U << lane)) == 0) continue;
    if (const MessageFault fault = take_beyond(in, had[lane]); fault != MessageFault::none) return fault;
  }
  return MessageFault::none;
}

}  // namespace

void WireWriter::put_had(const HadLanes& had) {
  unsigned has_beyond = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) has_beyond |= had[lane].beyond().empty() ? 0U : 1U << lane;
  put(static_cast<std::uint8_t>(has_beyond));
  put_varint(had[0].upto());
  for (std::size_t lane = 1; lane < kLanes; ++lane) put_varint(zigzag(had[lane].upto() - had[lane - 1].upto()));
  for (const VersionRanges& ranges : had) {
    if (ranges.beyond().empty()) continue;
    put_varint(ranges.beyond().size());
    Version last = ranges.upto();
    for (const VersionRange& range : ranges.beyond()) {
      put_varint(range.after - last);
      put_varint(range.upto - range.after);
      last = range.upto;
    }
  }
}

template <typename Write>
bool WireWriter::put_if_it_fits(Write&& write) {
  const std::size_t size_before = size_;
  write();
  if (size_ <= kMostMessage_bytes) return true;
  size_ = size_before;
  return false;
}

bool WireWriter::put_position(const LayerPosition& position) {
  return put_if_it_fits([&] {
    put_layer_id(position.id);
    put_had(position.had);
  });
}

bool WireWriter::put_wanted(const WantedLayer& wanted) {
  return put_if_it_fits([&] {
    put(wanted.layer);
    put_had(wanted.had);
  });
}

MessageFault take_position(mapper::ByteReader& in, LayerPosition& position) {
  return take_layer_id(in, position.id) ? take_had(in, position.had) : MessageFault::truncated;
}

MessageFault take_wanted(mapper::ByteReader& in, WantedLayer& wanted) {
  return in.take(wanted.layer) ? take_had(in, wanted.had) : MessageFault::truncated;
}

}  // namespace g3d::net
