// SPDX-License-Identifier: Apache-2.0
#include "net/own_layer.hpp"

namespace g3d::net {

OwnLayer::OwnLayer(LayerStore& store, const LayerId& self, Version restored_upto)
    : store_(store), index_(store.find_or_add(self)), restored_upto_(restored_upto), version_(restored_upto) {
  if (restored_upto == 0) return;
  // Gaps of starts before the last are closed: they may not become too many.
  for (const Lane lane : kAllLanes) {
    const VersionRange kept{0, store.had(index_, lane).highest()};
    (void)store.add_had(index_, lane, kept);
    has_gap_ = has_gap_ || kept.upto < restored_upto;
  }
}

void OwnLayer::commit() {
  const Version after = has_gap_ ? restored_upto_ : 0;
  for (const Lane lane : kAllLanes) (void)store_.add_had(index_, lane, {after, version_});
}

void OwnLayer::close_gap() {
  has_gap_ = false;
  commit();
}

}  // namespace g3d::net
