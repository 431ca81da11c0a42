// SPDX-License-Identifier: Apache-2.0
// Whom to ask for which layer, so that nothing comes twice: its writer while it is there, else whoever has more of it
// than we. A source that has more and gives nothing for a while is passed over for another. One thread.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/messages.hpp"
#include "net/layer_store.hpp"
#include "net/membership.hpp"

namespace g3d::net {

struct SourceRule {
  hal::TimeNs patience_ns = 1'500'000'000;
};

class LayerSources {
 public:
  static constexpr RobotId kNobody = 0;

  LayerSources(std::uint32_t most_layers, const SourceRule& rule = {})
      : rule_(rule), sources_(most_layers, kNobody), progress_ns_(most_layers, 0) {}

  /// Chooses anew where that is due. Peers whose layers are others now owe a word (Peer::owes_want).
  /// `own`: what only we write.
  void choose(const LayerStore& store, Membership& members, LayerIndex own, hal::TimeNs now_ns);
  /// From now on somebody in particular, as long as it has more.
  void ask(LayerIndex layer, Membership& members, RobotId robot);
  /// Something new of a layer has come.
  void note_progress(LayerIndex layer, hal::TimeNs now_ns) { progress_ns_[layer] = now_ns; }
  /// When that was, or when nobody had more.
  [[nodiscard]] hal::TimeNs progress_ns(LayerIndex layer) const { return progress_ns_[layer]; }
  [[nodiscard]] RobotId source(LayerIndex layer) const { return sources_[layer]; }

  /// Whether a peer is known to have more of a layer than we.
  [[nodiscard]] static bool has_more(const LayerStore& store, const Peer& peer, LayerIndex layer);

 private:
  struct Need {
    LayerIndex layer = kNoLayer;
    RobotId asked = kNobody;  ///< until now
    bool is_lacking = false;  ///< somebody has more
    bool is_stalled = false;  ///< and it does not come
  };
  [[nodiscard]] static RobotId choice(const LayerStore& store, Membership& members, const Need& need);

  SourceRule rule_;
  std::vector<RobotId> sources_;
  std::vector<hal::TimeNs> progress_ns_;
};

}  // namespace g3d::net
