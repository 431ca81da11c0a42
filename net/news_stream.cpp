// SPDX-License-Identifier: Apache-2.0
#include "net/news_stream.hpp"

#include <algorithm>

namespace g3d::net {

void NewsStream::find_layers(const LayerStore& store, const Membership& members) {
  one_lacks_.reset();
  some_lack_.reset();
  for (const Peer& peer : members.all()) {
    if (!peer.is_alive()) continue;
    for (std::size_t i = 0; i < peer.out.wanted_count(); ++i) {
      if (!peer.out.lacks(store, i)) continue;
      const LayerIndex layer = peer.out.wanted_layer(i);
      if (one_lacks_[layer]) some_lack_.set(layer);
      one_lacks_.set(layer);
    }
  }
}

VersionRange NewsStream::shared_gap(const LayerStore& store, const Membership& members, LayerIndex layer, Lane lane) {
  gaps_.clear();
  for (const Peer& peer : members.all()) {
    if (!peer.is_alive() || peer.out.in_flight() == OutgoingStream::kMostInFlight) continue;
    for (std::size_t i = 0; i < peer.out.wanted_count(); ++i) {
      if (peer.out.wanted_layer(i) != layer) continue;
      const VersionRange gap = peer.out.next_gap(store, i, lane);
      if (gap.after < gap.upto) gaps_.push_back(gap);
    }
  }
  std::sort(gaps_.begin(), gaps_.end(), [](const VersionRange& a, const VersionRange& b) {
    return a.after != b.after ? a.after < b.after : a.upto < b.upto;
  });
  VersionRange most;
  std::size_t most_count = 1;
  for (std::size_t begin = 0, end = 0; begin < gaps_.size(); begin = end) {
    while (end < gaps_.size() && gaps_[end].after == gaps_[begin].after) ++end;
    if (end - begin <= most_count) continue;
    most_count = end - begin;
    // No further than all of them lack it: nobody is to get anything twice.
    most = gaps_[begin];
  }
  return most;
}

void NewsStream::note(Membership& members, LayerIndex layer, Lane lane, const VersionRange& range, std::size_t bytes,
                      hal::TimeNs now_ns) const {
  for (Peer& peer : members.all()) {
    if (!peer.is_alive()) continue;
    for (std::size_t i = 0; i < peer.out.wanted_count(); ++i) {
      if (peer.out.wanted_layer(i) == layer) peer.out.note_news(next_sequence_, i, lane, range, bytes, now_ns);
    }
  }
}

bool NewsStream::next(const LayerStore& store, Membership& members, MessageWriter& message, hal::TimeNs now_ns) {
  find_layers(store, members);
  if (some_lack_.none()) return false;
  bool has_begun = false;
  bool has_room = true;
  for (const Lane lane : kAllLanes) {
    for (LayerIndex layer = 0; layer < store.layer_count() && has_room; ++layer) {
      if (!some_lack_[layer]) continue;
      while (has_room) {
        const VersionRange gap = shared_gap(store, members, layer, lane);
        if (gap.upto <= gap.after) break;
        if (!has_begun) message.begin_news(static_cast<std::uint16_t>(next_sequence_));
        const std::size_t size = message.size();
        const auto sent = write_segment(store, layer, lane, gap, message);
        if (sent) {
          has_begun = true;
          note(members, layer, lane, *sent, message.size() - size, now_ns);
        }
        has_room = sent && sent->upto == gap.upto;
      }
    }
  }
  if (has_begun) ++next_sequence_;
  return has_begun;
}

}  // namespace g3d::net
