// SPDX-License-Identifier: Apache-2.0
// What several robots want and none of them has: sent once, to all. That is fresh blocks of our own layer most of the
// time, but whatever two robots lack from the same place on counts, a layer of a third robot too. Who misses it is sent
// it again as anybody else, alone or with others (outgoing_stream.hpp). One thread; allocates nothing after the start.
#pragma once

#include <bitset>
#include <cstdint>
#include <vector>

#include "hal/messages.hpp"
#include "net/layer_store.hpp"
#include "net/membership.hpp"
#include "net/sync_message.hpp"

namespace g3d::net {

class NewsStream {
 public:
  explicit NewsStream(std::size_t most_peers) { gaps_.reserve(most_peers); }

  /// Writes the next message to all, and notes it as under way to whoever wants it. False if there is none now.
  [[nodiscard]] bool next(const LayerStore& store, Membership& members, MessageWriter& message, hal::TimeNs now_ns);
  /// Its number. They begin with 1.
  [[nodiscard]] std::uint32_t next_sequence() const { return next_sequence_; }

 private:
  static constexpr std::size_t kMostLayers = 512;

  /// Which layers two or more robots lack anything of.
  void find_layers(const LayerStore& store, const Membership& members);
  /// What most of them lack from the same place on; an empty range if that is none or one.
  [[nodiscard]] VersionRange shared_gap(const LayerStore& store, const Membership& members, LayerIndex layer,
                                        Lane lane);
  void note(Membership& members, LayerIndex layer, Lane lane, const VersionRange& range, std::size_t bytes,
            hal::TimeNs now_ns) const;

  std::uint32_t next_sequence_ = 1;
  std::vector<VersionRange> gaps_;  ///< of each robot; reserved
  std::bitset<kMostLayers> one_lacks_, some_lack_;
};

}  // namespace g3d::net
