// SPDX-License-Identifier: Apache-2.0
// Our own layer: the versions that we give, and what of it others may have. A robot that comes back with its layer and
// its counter goes on above every version that it may have used. Between what its disk kept and that there is a gap:
// the last second, which others may hold and give back. Once nobody who is in reach has more, it is closed; whoever
// comes later and has more differs in the digest.
// One thread.
#pragma once

#include "net/layer_store.hpp"
#include "net/wire_parts.hpp"

namespace g3d::net {

class OwnLayer {
 public:
  /// `restored_upto`: up to which version an earlier start may have told others; 0: this is the first.
  OwnLayer(LayerStore& store, const LayerId& self, Version restored_upto);

  [[nodiscard]] LayerIndex index() const { return index_; }
  [[nodiscard]] Version version() const { return version_; }
  void set_limit(Version limit) { limit_ = limit; }
  [[nodiscard]] bool may_publish() const { return version_ < limit_; }
  void advance() { ++version_; }
  /// All that was published is complete.
  void commit();

  [[nodiscard]] bool has_gap() const { return has_gap_; }
  void close_gap();
  /// Whether a layer is ours and nobody else can have anything of it that we lack.
  [[nodiscard]] bool is_ours_alone(LayerIndex layer) const { return layer == index_ && !has_gap_; }
  /// Whether a record or range that somebody sends may be taken: of our own layer only what we lost.
  [[nodiscard]] bool may_take(LayerIndex layer, Version version) const {
    return layer != index_ || (has_gap_ && version <= restored_upto_);
  }
  /// Whether contents of a layer that somebody has up to a version may be compared with ours.
  [[nodiscard]] bool may_compare(LayerIndex layer, Version highest) const {
    return layer != index_ || (restored_upto_ > 0 && highest <= version_);
  }

 private:
  LayerStore& store_;
  LayerIndex index_;
  Version restored_upto_;
  Version version_;
  Version limit_ = kMostVersion;
  bool has_gap_ = false;
};

}  // namespace g3d::net
