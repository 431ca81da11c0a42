// SPDX-License-Identifier: Apache-2.0
// Which other robots there are: who was heard lately, where it is to be reached, and what it is known to have. Bounded:
// who is new takes the place of whoever has been gone for longest, or is refused. Memory is sized at construction. One
// thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hal/messages.hpp"
#include "net/layer_store.hpp"
#include "net/outgoing_stream.hpp"
#include "net/sync_message.hpp"

namespace g3d::net {

/// Where datagrams go to: what the link makes of it.
using Address = std::uint64_t;
inline constexpr Address kEverybody = 0;

/// Who has sent a message, as far as is proved.
struct Sender {
  RobotId robot = 0;
  std::uint64_t session = 0;  ///< of one start of its program
  Address address = kEverybody;
};

enum class PeerState : std::uint8_t { alive, suspect, gone };

/// With two beacons a second, of which three in ten are lost: a robot that lives and has nothing to say is taken for
/// gone some four times an hour, by one that hears nobody else; and who has died is gone early enough for all others to
/// hear of it within 5 s of its death.
struct MembershipRule {
  hal::TimeNs suspect_after_ns = 2'500'000'000;
  hal::TimeNs gone_after_ns = 3'250'000'000;
};

/// What somebody is known to have of a layer.
struct KnownLayer {
  LaneVersions upto{};
  Version highest = 0;
  std::uint64_t content_hash = 0;  ///< as its last vector said; 0: nothing was said
  std::uint64_t taken_hash = 0;    ///< contents that we have reconciled ours with once: what differs since is ours
};

struct Peer {
  RobotId robot = 0;
  Address address = kEverybody;
  std::uint64_t session = 0;
  PeerState state = PeerState::gone;
  hal::TimeNs heard_ns = 0;
  std::uint64_t digest = 0;       ///< of its last beacon; 0: none was heard
  hal::TimeNs digest_ns = 0;      ///< since when it is that
  std::vector<KnownLayer> known;  ///< by layer of our store

  // What comes from it
  SeenNumbers seen;  ///< highest sequence numbers
  std::uint32_t unanswered = 0;
  hal::TimeNs first_unanswered_ns = 0;
  hal::TimeNs data_ns = 0;  ///< data or news have come
  hal::TimeNs want_ns = 0;
  int silent_wants = 0;  ///< in a row; each makes the next one later
  bool owes_want = false;
  LayerIndex want_turn = 0;  ///< with which layer the next word to it begins
  hal::TimeNs vector_asked_ns = 0;
  hal::TimeNs vector_ns = 0;  ///< when it last told all that it has; 0: never
  bool owes_vector = false;

  OutgoingStream out;  ///< what goes to it

  [[nodiscard]] bool is_alive() const { return state == PeerState::alive; }
};

class Membership {
 public:
  Membership(std::size_t most_peers, std::uint32_t most_layers, const MembershipRule& rule = {});

  /// Somebody was heard. nullptr: there are too many already.
  /// Another session than before makes all void that was known of a robot.
  Peer* heard(const Sender& sender, hal::TimeNs now_ns);
  /// Who has not been heard for long is suspect, then gone.
  void on_time(hal::TimeNs now_ns);

  [[nodiscard]] Peer* find(RobotId robot);
  [[nodiscard]] std::span<Peer> all() { return {peers_.data(), count_}; }
  [[nodiscard]] std::span<const Peer> all() const { return {peers_.data(), count_}; }
  [[nodiscard]] std::uint64_t refused() const { return refused_; }

 private:
  std::vector<Peer> peers_;  ///< never grows
  std::size_t count_ = 0;
  MembershipRule rule_;
  std::uint64_t refused_ = 0;
};

}  // namespace g3d::net
