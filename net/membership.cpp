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
  peer.seen = {};
  peer.unanswered = 0;
  peer.silent_wants = 0;
  peer.owes_vector = false;
  peer.out.clear();
}

}  // namespace

Membership::Membership(std::size_t most_peers, std::uint32_t most_layers, const MembershipRule& rule)
    : peers_(most_peers), rule_(rule) {
  for (Peer& peer : peers_) peer.known.resize(most_layers);
}

Peer* Membership::find(RobotId robot) {
  const auto it = std::find_if(all().begin(), all().end(), [&](const Peer& peer) { return peer.robot == robot; });
  return it == all().end() ? nullptr : &*it;
}

Peer* Membership::heard(const Sender& sender, hal::TimeNs now_ns) {
  Peer* peer = find(sender.robot);
  if (peer == nullptr) {
    if (count_ < peers_.size()) {
      peer = &peers_[count_++];
    } else {
      const auto longest = std::min_element(all().begin(), all().end(),
                                            [](const Peer& a, const Peer& b) { return a.heard_ns < b.heard_ns; });
      if (longest == all().end() || longest->state != PeerState::gone) {
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
  for (Peer& peer : all()) {
    const hal::TimeNs silent_ns = now_ns - peer.heard_ns;
    peer.state = silent_ns > rule_.gone_after_ns      ? PeerState::gone
                 : silent_ns > rule_.suspect_after_ns ? PeerState::suspect
                                                      : PeerState::alive;
  }
}

}  // namespace g3d::net
