// SPDX-License-Identifier: Apache-2.0
#include "net/gossip.hpp"

#include <algorithm>
#include <utility>

namespace g3d::net {
namespace {

constexpr hal::TimeNs kGossipChoice_ns = 50'000'000;
/// Digests differ all the time while something is on its way; only what lasts is a puzzle.
constexpr hal::TimeNs kGossipPuzzled_ns = 1'000'000'000;
/// But in a fleet that never comes to rest somebody is asked even so.
constexpr hal::TimeNs kGossipAsk_ns = 5'000'000'000;
constexpr std::size_t kGossipLayersPerBeacon = 4;
/// Records of a refused robot that go each time; they take a millisecond.
constexpr std::uint32_t kGossipDropped = 1024;
/// Who was asked for all that it has, and said nothing, is asked again.
constexpr hal::TimeNs kGossipAgain_ns = 250'000'000;
/// No datagram is under way for so long.
constexpr hal::TimeNs kGossipNumbers_ns = 10'000'000'000;
/// What may be sent at once after a pause.
constexpr double kGossipBurst_s = 0.02;

ReconcilerOptions with_seed(ReconcilerOptions options, std::uint64_t seed) {
  options.seed = seed;
  return options;
}

}  // namespace

Gossip::Gossip(const GossipOptions& options, LayerStore& store, Link& link)
    : options_(options),
      store_(store),
      link_(link),
      own_(store, options.self, options.restored_upto),
      members_(options.most_peers, store.most_layers(), options.membership),
      sources_(store.most_layers(), options.sources),
      // Robots that start together do not speak together.
      beacon_ns_(static_cast<hal::TimeNs>(mixed(options.seed, options.self.robot) %
                                          static_cast<std::uint64_t>(options.beacon_period_ns)) -
                 options.beacon_period_ns),
      answer_after_ns_(options.answer_after_ns),
      news_(options.most_peers),
      told_(store.most_layers()),
      reconciler_(with_seed(options.reconciler, options.seed), store, [this](RobotId to, const WireWriter& message) {
        if (const Peer* peer = members_.find(to); peer != nullptr)
          send(peer->address, MessageKind::reconcile, message.bytes());
      }) {}

bool Gossip::publish(RecordKey key, Lane lane, mapper::ByteSpan payload) {
  if (payload.size() > kMostPayload_bytes) return false;
  if (!own_.may_publish()) {
    ++counts_.unreserved_records;
    return false;
  }
  if (store_.put(own_.index(), key, own_.version() + 1, lane, payload) != LayerStore::Put::stored) return false;
  own_.advance();
  return true;
}

void Gossip::commit(hal::TimeNs now_ns) {
  own_.commit();
  stored_ns_ = now_ns;
}

LayerVersions Gossip::versions_of(LayerIndex layer) const {
  return {store_.id(layer), store_.upto(layer), store_.highest(layer), store_.content_hash(layer)};
}

LayerIndex Gossip::layer_of(const LayerId& id) {
  const LayerIndex layer = store_.find_or_add(id);
  if (layer == kNoLayer) ++(store_.is_refused_robot(id.robot) ? counts_.refused_robots : counts_.refused_layers);
  return layer;
}

void Gossip::note_known(Peer& peer, const LayerVersions& layer) {
  const LayerIndex index = layer_of(layer.id);
  if (index == kNoLayer) return;
  KnownLayer& known = peer.known[index];
  for (std::size_t lane = 0; lane < kLanes; ++lane) known.upto[lane] = std::max(known.upto[lane], layer.upto[lane]);
  known.highest = std::max(known.highest, layer.highest);
}

// --- what comes

void Gossip::on_message(const Sender& from, mapper::ByteSpan message, hal::TimeNs now_ns) {
  if (from.robot == options_.self.robot || message.empty()) return;
  ++counts_.received_messages;
  if (store_.is_refused_robot(from.robot)) {
    ++counts_.refused_robots;
    return;
  }
  Peer* peer = members_.heard(from, now_ns);
  if (peer == nullptr) return;
  switch (static_cast<MessageKind>(message[0])) {
    case MessageKind::beacon:
      return on_beacon(*peer, message, now_ns);
    case MessageKind::vector:
      return on_vector(*peer, message, now_ns);
    case MessageKind::want:
      return on_want(*peer, message, now_ns);
    case MessageKind::wants:
      return on_wants(*peer, message, now_ns);
    case MessageKind::data:
    case MessageKind::news:
      return on_data(*peer, message, now_ns);
    case MessageKind::reconcile:
      return note_fault(MessageFault::unknown_kind);
  }
  if (const MessageFault fault = reconciler_.on_message(from.robot, message, now_ns); fault != MessageFault::none) {
    note_fault(fault);
  }
}

void Gossip::on_beacon(Peer& peer, mapper::ByteSpan message, hal::TimeNs now_ns) {
  std::uint64_t digest = 0;
  if (const MessageFault fault = read_beacon(message, digest, layers_); fault != MessageFault::none) {
    return note_fault(fault);
  }
  if (digest != peer.digest) peer.digest_ns = now_ns;
  peer.digest = digest;
  for (const LayerVersions& layer : layers_.all()) note_known(peer, layer);
}

void Gossip::on_vector(Peer& peer, mapper::ByteSpan message, hal::TimeNs now_ns) {
  bool wants_answer = false;
  if (const MessageFault fault = read_vector(message, wants_answer, layers_); fault != MessageFault::none) {
    return note_fault(fault);
  }
  peer.owes_vector = peer.owes_vector || wants_answer;
  peer.vector_ns = now_ns;
  for (const LayerVersions& layer : layers_.all()) {
    // It may have begun anew: what it says now counts, not what it had once.
    if (const LayerIndex index = layer_of(layer.id); index != kNoLayer) {
      KnownLayer& known = peer.known[index];
      known = {layer.upto, layer.highest, layer.content_hash, known.taken_hash};
    }
  }
}

void Gossip::on_want(Peer& peer, mapper::ByteSpan message, hal::TimeNs now_ns) {
  SeenNumbers seen;
  if (const MessageFault fault = read_want(message, seen, wanted_); fault != MessageFault::none) {
    return note_fault(fault);
  }
  peer.out.on_want(store_, seen, news_.next_sequence(), wanted_.all(), now_ns);
}

void Gossip::on_wants(Peer& peer, mapper::ByteSpan message, hal::TimeNs now_ns) {
  std::optional<SeenNumbers> seen;
  const MessageFault fault = read_wants(message, alias_of(options_.self.robot), seen, wanted_);
  if (fault != MessageFault::none) return note_fault(fault);
  if (seen) peer.out.on_want(store_, *seen, news_.next_sequence(), wanted_.all(), now_ns);
}

/// Puts the records of a message whose ranges can be kept into the store.
class Gossip::Applying final : public DataVisitor {
 public:
  Applying(Gossip& gossip, Peer& peer, hal::TimeNs now_ns) : gossip_(gossip), peer_(peer), now_ns_(now_ns) {}
  void on_record(const DataRecord& record) override {
    const LayerIndex layer = gossip_.store_.find(record.layer);
    if (layer == kNoLayer || !gossip_.own_.may_take(layer, record.version)) {
      all_kept_ = false;
      return;
    }
    // The range may become one too many only at its end: what comes before it then waits for the next time.
    if (!gossip_.store_.had(layer, record.lane).has_room_for({record.version - 1, record.version})) {
      all_kept_ = false;
      return;
    }
    switch (gossip_.store_.put(layer, record.key, record.version, record.lane, record.payload)) {
      case LayerStore::Put::stored:
        ++gossip_.counts_.stored_records;
        gossip_.stored_ns_ = now_ns_;
        return;
      case LayerStore::Put::superseded:
        ++gossip_.counts_.superseded_records;
        return;
      case LayerStore::Put::conflicting:
      case LayerStore::Put::refused:
        break;
    }
    ++gossip_.counts_.refused_records;
    all_kept_ = false;
  }
  void on_segment(const DataSegment& segment) override {
    is_empty_ = false;
    const bool all_kept = std::exchange(all_kept_, true);
    const LayerIndex layer = gossip_.store_.find(segment.layer);
    if (layer == kNoLayer) ++gossip_.counts_.unknown_layers;
    if (layer == kNoLayer || !gossip_.own_.may_take(layer, segment.range.upto)) return;
    is_asked_ = is_asked_ || gossip_.sources_.source(layer) == peer_.robot;
    if (!all_kept) return;
    if (!gossip_.store_.add_had(layer, segment.lane, segment.range)) {
      ++gossip_.counts_.refused_ranges;
      return;
    }
    KnownLayer& known = peer_.known[layer];
    known.highest = std::max(known.highest, segment.range.upto);
    gossip_.sources_.note_progress(layer, now_ns_);
  }
  /// Some of it was asked for from whom it came.
  [[nodiscard]] bool is_asked() const { return is_asked_; }
  [[nodiscard]] bool is_empty() const { return is_empty_; }

 private:
  Gossip& gossip_;
  Peer& peer_;
  hal::TimeNs now_ns_;
  bool all_kept_ = true;
  bool is_asked_ = false;
  bool is_empty_ = true;
};

void Gossip::on_data(Peer& peer, mapper::ByteSpan message, hal::TimeNs now_ns) {
  std::uint16_t sequence = 0;
  if (const MessageFault fault = read_data(message, sequence, nullptr); fault != MessageFault::none) {
    return note_fault(fault);
  }
  Applying applying(*this, peer, now_ns);
  (void)read_data(message, sequence, &applying);
  const bool is_news = static_cast<MessageKind>(message[0]) == MessageKind::news;
  std::uint16_t& seen = is_news ? peer.seen.news : peer.seen.data;
  // After a long silence the numbers may have gone round.
  const bool is_new = now_ns - peer.data_ns > kGossipNumbers_ns;
  if (is_new || static_cast<std::int16_t>(static_cast<std::uint16_t>(sequence - seen)) > 0) seen = sequence;
  peer.data_ns = now_ns;
  peer.silent_wants = 0;
  // Without anything in it, it asks for a word.
  peer.owes_want = peer.owes_want || applying.is_empty();
  // News that somebody else asked for are good to have, but nobody waits for our word.
  if (is_news && !applying.is_asked()) return;
  if (peer.unanswered++ == 0) peer.first_unanswered_ns = now_ns;
}

// --- what goes

bool Gossip::send(Address to, MessageKind kind, mapper::ByteSpan message) {
  const std::size_t bytes = message.size() + options_.bytes_around_message;
  allowance_bytes_ -= static_cast<double>(bytes);
  ++counts_.sent_messages[static_cast<std::size_t>(kind)];
  counts_.sent_bytes[static_cast<std::size_t>(kind)] += bytes;
  return link_.send(to, message);
}

void Gossip::on_time(hal::TimeNs now_ns) {
  const double most_bytes = std::max(2.0 * kMostMessage_bytes, options_.bandwidth_Bps * kGossipBurst_s);
  allowance_bytes_ += options_.bandwidth_Bps * 1e-9 * static_cast<double>(now_ns - allowance_ns_);
  allowance_bytes_ = std::min(allowance_bytes_, most_bytes);
  allowance_ns_ = now_ns;

  (void)store_.drop_some(kGossipDropped);
  members_.on_time(now_ns);
  if (own_.has_gap()) look_for_own(now_ns);
  if (now_ns - chosen_ns_ >= kGossipChoice_ns) {
    chosen_ns_ = now_ns;
    sources_.choose(store_, members_, own_.has_gap() ? kNoLayer : own_.index(), now_ns);
    note_answer_time();
  }
  if (now_ns - beacon_ns_ >= options_.beacon_period_ns) send_beacon(now_ns);
  send_wants(now_ns);
  for (Peer& peer : members_.all()) {
    if (!peer.is_alive()) continue;
    if (std::exchange(peer.owes_vector, false)) send_vector(peer, false);
    reconcile_with(peer, now_ns);
  }
  ask_if_puzzled(now_ns);
  reconciler_.on_time(now_ns);
  // Whatever still differs is ours: it is for the other to ask.
  if (const auto finished = reconciler_.take_finished()) {
    if (Peer* peer = members_.find(finished->peer); peer != nullptr) {
      peer->known[finished->layer].taken_hash = finished->their_content;
    }
  }
  send_data(now_ns);
}

void Gossip::send_beacon(hal::TimeNs now_ns) {
  beacon_ns_ = now_ns;
  message_.begin_beacon(store_.digest());
  std::size_t told = 0;
  // Our own layer every time, for nobody else knows better; others when they have changed.
  for (LayerIndex i = 0; i < store_.layer_count() && told < kGossipLayersPerBeacon; ++i) {
    const LayerIndex layer = i == 0 ? own_.index() : i <= own_.index() ? i - 1 : i;
    const LayerVersions now = versions_of(layer);
    const LayerVersions& before = told_[layer];
    if (store_.is_refused(layer)) continue;
    const bool is_told =
        layer == own_.index() ? now.highest == 0 : now.upto == before.upto && now.highest == before.highest;
    if (is_told || !message_.add_layer(now)) continue;
    told_[layer] = now;
    ++told;
  }
  send(kEverybody, MessageKind::beacon, message_.bytes());
}

bool Gossip::is_settled(hal::TimeNs now_ns) const {
  return now_ns - stored_ns_ >= kGossipPuzzled_ns &&
         std::none_of(members_.all().begin(), members_.all().end(),
                      [&](const Peer& peer) { return peer.is_alive() && lacks_from(peer); });
}

void Gossip::ask_if_puzzled(hal::TimeNs now_ns) {
  if (now_ns - asked_ns_ < kGossipPuzzled_ns) return;
  const bool is_overdue = now_ns - asked_ns_ >= kGossipAsk_ns;
  if (!is_overdue && !is_settled(now_ns)) return;
  const std::span<Peer> peers = members_.all();
  for (std::size_t i = 0; i < peers.size(); ++i) {
    Peer& peer = peers[(ask_turn_ + i) % peers.size()];
    if (!peer.is_alive() || peer.digest == 0 || peer.digest == store_.digest()) continue;
    if (!is_overdue && now_ns - peer.digest_ns < kGossipPuzzled_ns) continue;
    ask_turn_ = (ask_turn_ + i + 1) % peers.size();
    asked_ns_ = now_ns;
    peer.vector_asked_ns = now_ns;
    return send_vector(peer, true);
  }
}

void Gossip::send_vector(Peer& peer, bool wants_answer) {
  message_.begin_vector(wants_answer);
  // More layers than fit are told in turns.
  const std::uint32_t count = store_.layer_count();
  std::uint32_t told = 0;
  for (; told < count; ++told) {
    const auto layer = static_cast<LayerIndex>((vector_turn_ + told) % count);
    if (!store_.is_refused(layer) && !message_.add_layer(versions_of(layer))) break;
  }
  vector_turn_ = (vector_turn_ + told) % count;
  send(peer.address, MessageKind::vector, message_.bytes());
}

void Gossip::reconcile_with(Peer& peer, hal::TimeNs now_ns) {
  if (reconciler_.is_busy()) return;
  for (LayerIndex layer = 0; layer < store_.layer_count(); ++layer) {
    if (!store_.is_unclaimed(layer) || own_.is_ours_alone(layer) || peer.known[layer].highest == 0) continue;
    return reconciler_.begin(peer.robot, layer, now_ns);
  }
  if (now_ns - peer.vector_asked_ns > kGossipPuzzled_ns) return;
  for (LayerIndex layer = 0; layer < store_.layer_count(); ++layer) {
    KnownLayer& known = peer.known[layer];
    if (known.content_hash == 0 || known.content_hash == store_.content_hash(layer) || store_.is_refused(layer))
      continue;
    if (!own_.may_compare(layer, known.highest)) continue;
    if (LayerSources::has_more(store_, peer, layer) || now_ns - stored_ns_ < kGossipPuzzled_ns) continue;
    if (known.content_hash == known.taken_hash) continue;
    return reconciler_.begin(peer.robot, layer, now_ns);
  }
}

void Gossip::look_for_own(hal::TimeNs now_ns) {
  bool is_known_to_all = true;
  bool is_alone = true;
  for (Peer& peer : members_.all()) {
    if (!peer.is_alive()) continue;
    is_alone = false;
    if (LayerSources::has_more(store_, peer, own_.index()) || peer.vector_ns == 0) is_known_to_all = false;
    if (peer.vector_ns != 0 || (peer.vector_asked_ns != 0 && now_ns - peer.vector_asked_ns < kGossipAgain_ns)) continue;
    peer.vector_asked_ns = now_ns;
    send_vector(peer, true);
  }
  if (is_alone || !is_known_to_all) return;
  // Whoever is out of reach and has more of it will differ in the digest later.
  own_.close_gap();
}

void Gossip::send_data(hal::TimeNs now_ns) {
  while (allowance_bytes_ > 0.0 && news_.next(store_, members_, message_, now_ns)) {
    send(kEverybody, MessageKind::news, message_.bytes());
  }
  const std::span<Peer> peers = members_.all();
  std::size_t idle = 0;
  while (!peers.empty() && idle < peers.size() && allowance_bytes_ > 0.0) {
    Peer& peer = peers[data_turn_++ % peers.size()];
    ++idle;
    if (!peer.is_alive() || !link_.has_room(peer.address) || !peer.out.next(store_, message_, now_ns)) continue;
    send(peer.address, MessageKind::data, message_.bytes());
    idle = 0;
  }
}

}  // namespace g3d::net
