// SPDX-License-Identifier: Apache-2.0
// The shared map among robots: everybody tells everybody what it has, asks one of those who have more, and is sent what
// it lacks, until all have the same. Layers travel through third robots and outlive their writers.
//
//   beacon to all, twice a second ──▶ who has more? ──▶ want to a source ──▶ data, paced ──▶ store ──▶ want (answer)
//
// What two or more want from us is sent once, to all (news), and whoever owes an answer to several gives it to all in
// one message: so what a robot sends grows with what it has to say, not with how many there are to hear it.
//
// Who is told of a layer once is sent its news at once. Messages may be lost, doubled, late or out of order, and robots
// may start anew: nothing is applied but whole records, and the newest stands. A robot that comes back with its layer
// and its counter goes on where the counter may have been; what its disk had lost the others give back to it. If two
// have the same versions of a layer and yet not the same records (a writer died between two of them), they find out
// what each lacks (reconciler.hpp).
//
// No threads, no clock, nothing allocated after construction: whoever owns the link calls it, with the time.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/messages.hpp"
#include "net/layer_sources.hpp"
#include "net/layer_store.hpp"
#include "net/membership.hpp"
#include "net/news_stream.hpp"
#include "net/own_layer.hpp"
#include "net/reconciler.hpp"
#include "net/sync_message.hpp"

namespace g3d::net {

/// Where messages leave. They may be lost; false: not even tried.
class Link {
 public:
  virtual ~Link() = default;
  virtual bool send(Address to, mapper::ByteSpan message) = 0;
  /// False: data had better wait, as it would be dropped on the way out. What is not sent is not counted as sent.
  [[nodiscard]] virtual bool has_room(Address /*to*/) const { return true; }
};

struct GossipOptions {
  LayerId self;  ///< our own layer; not of a robot that the store refuses
  /// Of our own layer, where the store holds it from an earlier start: up to which version others may have been told of
  /// it. We go on above. 0: it begins now.
  Version restored_upto = 0;
  std::uint64_t seed = 0;  ///< a random number: who starts together does not speak together
  std::size_t most_peers = 64;
  MembershipRule membership;
  SourceRule sources;
  ReconcilerOptions reconciler;
  double bandwidth_Bps = 250'000.0;       ///< what we may send
  std::size_t bytes_around_message = 31;  ///< what sealing adds: counts as sent
  hal::TimeNs beacon_period_ns = 500'000'000;
  hal::TimeNs answer_after_ns = 40'000'000;  ///< data is answered so late at the latest
  std::uint32_t answer_every = 16;           ///< or after so many datagrams
  /// Of so many robots each answers twice as late, of twice as many three times: or all would answer all at once.
  std::size_t answer_crowd = 16;
};

struct GossipCounts {
  std::array<std::uint64_t, kMessageKinds> sent_messages{};  ///< by MessageKind
  std::array<std::uint64_t, kMessageKinds> sent_bytes{};
  std::uint64_t received_messages = 0;
  std::uint64_t stored_records = 0;
  std::uint64_t superseded_records = 0;                ///< had that or newer ones already
  std::uint64_t refused_records = 0;                   ///< no room
  std::uint64_t refused_ranges = 0;                    ///< too many gaps before them
  std::uint64_t refused_layers = 0;                    ///< no room for a layer more
  std::uint64_t refused_robots = 0;                    ///< messages and layers of robots that the store refuses
  std::uint64_t unreserved_records = 0;                ///< own ones that the version limit kept back
  std::uint64_t unknown_layers = 0;                    ///< segments of layers whose whole name was not heard yet
  std::array<std::uint64_t, kMessageFaults> faults{};  ///< by MessageFault
  [[nodiscard]] std::uint64_t all_sent_bytes() const {
    std::uint64_t sum = 0;
    for (const std::uint64_t bytes : sent_bytes) sum += bytes;
    return sum;
  }
};

class Gossip {
 public:
  /// `store`: outlives this; it has at least one layer free, for our own.
  Gossip(const GossipOptions& options, LayerStore& store, Link& link);

  /// A record of our own layer, of the next version. False if the store has no room, it is longer than
  /// kMostPayload_bytes, or the version is above the limit. What was published is on its way after commit().
  bool publish(RecordKey key, Lane lane, mapper::ByteSpan payload);
  void commit(hal::TimeNs now_ns);
  /// Versions above this one are not used: a later start could not know of them. At first there is no limit.
  void set_version_limit(Version limit) { own_.set_limit(limit); }

  /// A message of a robot whose word is genuine. What an earlier start of it had sent comes no more once a later one
  /// was heard.
  void on_message(const Sender& from, mapper::ByteSpan message, hal::TimeNs now_ns);
  /// Every 5 to 20 ms: sends what is due, as far as bandwidth goes.
  void on_time(hal::TimeNs now_ns);

  [[nodiscard]] const Membership& members() const { return members_; }
  [[nodiscard]] const LayerSources& sources() const { return sources_; }
  [[nodiscard]] const GossipCounts& counts() const { return counts_; }
  [[nodiscard]] const ReconcilerCounts& reconciler_counts() const { return reconciler_.counts(); }
  [[nodiscard]] LayerIndex own_layer() const { return own_.index(); }
  [[nodiscard]] Version version() const { return own_.version(); }
  [[nodiscard]] const GossipOptions& options() const { return options_; }

 private:
  class Applying;
  /// For what we lost with our last start.
  void look_for_own(hal::TimeNs now_ns);
  void on_beacon(Peer& peer, mapper::ByteSpan message, hal::TimeNs now_ns);
  void on_vector(Peer& peer, mapper::ByteSpan message, hal::TimeNs now_ns);
  void on_want(Peer& peer, mapper::ByteSpan message, hal::TimeNs now_ns);
  void on_wants(Peer& peer, mapper::ByteSpan message, hal::TimeNs now_ns);
  /// Data or news.
  void on_data(Peer& peer, mapper::ByteSpan message, hal::TimeNs now_ns);
  void note_fault(MessageFault fault) { ++counts_.faults[static_cast<std::size_t>(fault)]; }
  /// kNoLayer: no room.
  [[nodiscard]] LayerIndex layer_of(const LayerId& id);
  void note_known(Peer& peer, const LayerVersions& layer);

  void reconcile_with(Peer& peer, hal::TimeNs now_ns);
  void send_beacon(hal::TimeNs now_ns);
  void send_wants(hal::TimeNs now_ns);
  void send_want(Peer& peer, hal::TimeNs now_ns);
  /// To all, for everybody whom we owe a word.
  void send_words(hal::TimeNs now_ns);
  void note_word(Peer& peer, hal::TimeNs now_ns);
  /// What we want from it, into the message. False if not all of it fits.
  bool add_wanted_from(Peer& peer);
  void send_vector(Peer& peer, bool wants_answer);
  void send_data(hal::TimeNs now_ns);
  /// Nothing of our store has changed for a while, and nobody is known to have more.
  [[nodiscard]] bool is_settled(hal::TimeNs now_ns) const;
  void ask_if_puzzled(hal::TimeNs now_ns);
  [[nodiscard]] bool want_is_due(const Peer& peer, hal::TimeNs now_ns) const;
  void note_answer_time();
  [[nodiscard]] bool lacks_from(const Peer& peer) const;
  bool send(Address to, MessageKind kind, mapper::ByteSpan message);
  [[nodiscard]] LayerVersions versions_of(LayerIndex layer) const;

  GossipOptions options_;
  LayerStore& store_;
  Link& link_;
  OwnLayer own_;
  Membership members_;
  LayerSources sources_;
  GossipCounts counts_;
  MessageWriter message_;
  LayerList layers_;   ///< of the message that is read
  WantedList wanted_;  ///< the same
  double allowance_bytes_ = 0.0;
  hal::TimeNs allowance_ns_ = 0;
  hal::TimeNs beacon_ns_;
  hal::TimeNs answer_after_ns_ = 0;  ///< as many as we are now
  std::size_t data_turn_ = 0;
  NewsStream news_;
  std::size_t vector_turn_ = 0;
  std::vector<LayerVersions> told_;  ///< by layer: what our last beacons have told
  hal::TimeNs stored_ns_ = 0;        ///< when the last record was
  hal::TimeNs chosen_ns_ = 0;
  hal::TimeNs asked_ns_ = 0;
  std::size_t ask_turn_ = 0;
  Reconciler reconciler_;
};

}  // namespace g3d::net
