// SPDX-License-Identifier: Apache-2.0
#include "net/layer_sources.hpp"

#include <algorithm>

namespace g3d::net {

bool LayerSources::has_more(const LayerStore& store, const Peer& peer, LayerIndex layer) {
  if (store.is_refused(layer)) return false;
  const KnownLayer& known = peer.known[layer];
  for (const Lane lane : kAllLanes) {
    if (known.upto[static_cast<std::size_t>(lane)] > store.had(layer, lane).upto()) return true;
  }
  return known.highest > store.highest(layer);
}

RobotId LayerSources::choice(const LayerStore& store, Membership& members, const Need& need) {
  const RobotId writer = store.id(need.layer).robot;
  const Peer* asked = members.find(need.asked);
  const bool asked_is_there = asked != nullptr && asked->is_alive();
  // Back to the writer only when nothing is under way from another.
  const bool writer_may = !asked_is_there || need.asked == writer || !need.is_lacking;
  if (const Peer* peer = members.find(writer); peer != nullptr && peer->is_alive() && writer_may && !need.is_stalled) {
    return writer;
  }
  // The next one in order of ids after whom we ask now, so that all have their turn.
  RobotId next = kNobody;
  RobotId first = kNobody;
  for (const Peer& peer : members.all()) {
    if (!peer.is_alive() || !has_more(store, peer, need.layer)) continue;
    if (first == kNobody || peer.robot < first) first = peer.robot;
    if (peer.robot > need.asked && (next == kNobody || peer.robot < next)) next = peer.robot;
  }
  // Whoever gave us all that it has may get more: it stays until another one has more.
  const bool may_stay = asked_is_there && (first == kNobody || has_more(store, *asked, need.layer));
  if (may_stay && !need.is_stalled) return need.asked;
  return next != kNobody ? next : first;
}

void LayerSources::choose(const LayerStore& store, Membership& members, LayerIndex own, hal::TimeNs now_ns) {
  for (LayerIndex layer = 0; layer < store.layer_count(); ++layer) {
    if (layer == own || store.is_refused(layer)) continue;
    const bool is_lacking = std::any_of(members.all().begin(), members.all().end(), [&](const Peer& peer) {
      return peer.is_alive() && has_more(store, peer, layer);
    });
    if (!is_lacking) progress_ns_[layer] = now_ns;
    const bool is_stalled = now_ns - progress_ns_[layer] > rule_.patience_ns;
    const RobotId before = sources_[layer];
    const RobotId chosen = choice(store, members, {layer, before, is_lacking, is_stalled});
    if (is_stalled) progress_ns_[layer] = now_ns;
    if (chosen == before) continue;
    ask(layer, members, chosen);
  }
}

void LayerSources::ask(LayerIndex layer, Membership& members, RobotId robot) {
  for (const RobotId told : {sources_[layer], robot}) {
    if (Peer* peer = members.find(told); peer != nullptr) peer->owes_want = true;
  }
  sources_[layer] = robot;
}

}  // namespace g3d::net
