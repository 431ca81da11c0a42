// SPDX-License-Identifier: Apache-2.0
#include "net/membership.hpp"

#include <algorithm>

namespace g3d::net {
namespace {

void forget(Peer& peer) {
  std::fill(peer.known.begin(), peer.known.end(), KnownLayer{});
  peer.digest = 0;
  peer.want_ns = peer.data_ns = peer.vector_asked_ns = peer.vector_ns = 0;
  // Whatever it is to give us, it does not know.
  peer.owes_want = true;
  peer.last_seen = 0;
  peer.unanswered = 0;
  peer.silent_wants = 0;
  peer.owes_vector = false;
  peer.out.clear();
}

}  // namespace

Membership::Membership(std::size_t most_peers, std::uint32_t most_layers, const MembershipRule& rule)
    : most_peers_(most_peers), most_layers_(most_layers), rule_(rule) {
  peers_.reserve(most_peers);
}

Peer* Membership::find(RobotId robot) {
  const auto it = std::find_if(peers_.begin(), peers_.end(), [&](const Peer& peer) { return peer.robot == robot; });
  return it == peers_.end() ? nullptr : &*it;
}

Peer* Membership::heard(const Sender& sender, hal::TimeNs now_ns) {
  Peer* peer = find(sender.robot);
  if (peer == nullptr) {
    if (peers_.size() < most_peers_) {
      peer = &peers_.emplace_back();
      peer->known.resize(most_layers_);
    } else {
      const auto longest = std::min_element(peers_.begin(), peers_.end(),
                                            [](const Peer& a, const Peer& b) { return a.heard_ns < b.heard_ns; });
      if (longest == peers_.end() || longest->state != PeerState::gone) {
        ++refused_;
        return nullptr;
      }
      peer = &*longest;
      forget(*peer);
    }
    peer->robot = sender.robot;
    peer->session = sender.session;
  }
  if (peer->session != sender.session) forget(*peer);
  peer->session = sender.session;
  peer->address = sender.address;
  peer->heard_ns = now_ns;
  peer->state = PeerState::alive;
  return peer;
}

void Membership::on_time(hal::TimeNs now_ns) {
  for (Peer& peer : peers_) {
    const hal::TimeNs silent_ns = now_ns - peer.heard_ns;
    peer.state = silent_ns > rule_.gone_after_ns      ? PeerState::gone
                 : silent_ns > rule_.suspect_after_ns ? PeerState::suspect
                                                      : PeerState::alive;
  }
}

}  // namespace g3d::net
