// SPDX-License-Identifier: Apache-2.0
#include "net/reconciler.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace g3d::net {

Reconciler::Reconciler(const ReconcilerOptions& options, LayerStore& store, Send send)
    : options_(options), store_(store), send_(std::move(send)), decoder_(options.most_differences) {
  lacking_.reserve(options.most_differences);
}

void Reconciler::begin(RobotId peer, LayerIndex layer, hal::TimeNs now_ns) {
  ++counts_.opened;
  ++exchanges_;
  const SketchSalt salt{mixed(options_.seed, exchanges_), mixed(exchanges_, options_.seed)};
  open_ =
      Exchange{peer, layer, salt, store_.content_hash(layer), {}, {}, options_.first_symbols, false, now_ns, now_ns};
  lacking_.clear();
  decoder_.start(salt);
  ask(now_ns);
}

void Reconciler::on_time(hal::TimeNs now_ns) {
  if (!open_) return;
  if (store_.is_refused(open_->layer)) return end(counts_.ended_changed);
  if (now_ns - open_->heard_ns > options_.give_up_ns) return end(counts_.ended_silent);
  if (now_ns - std::max(open_->asked_ns, open_->heard_ns) >= options_.ask_again_ns) ask(now_ns);
}

void Reconciler::ask(hal::TimeNs now_ns) {
  open_->asked_ns = now_ns;
  if (open_->knows_difference) return ask_for_records();
  // What is missing of the wanted ones, a run at a time.
  for (std::uint32_t i = 0; i < open_->wanted_symbols;) {
    if (decoder_.has_symbol(i)) {
      ++i;
      continue;
    }
    std::uint32_t end = i;
    while (end < open_->wanted_symbols && !decoder_.has_symbol(end)) ++end;
    ask_for_symbols(i, end);
    i = end;
  }
}

void Reconciler::ask_for_symbols(std::uint32_t first, std::uint32_t end) {
  // So many fit into an answer whose counts and position are long.
  constexpr std::uint32_t kPerAnswer = 64;
  for (; first < end; first += kPerAnswer) {
    const auto count = static_cast<std::uint8_t>(std::min(kPerAnswer, end - first));
    write_sketch_ask(out_, {store_.id(open_->layer), open_->salt, first, count});
    send_(open_->peer, out_);
  }
}

void Reconciler::ask_for_records() {
  // A few datagrams of them at a time: the answers are ten times as long.
  constexpr std::size_t kAsksAtOnce = 2;
  const std::span<const SketchId> all = lacking_;
  for (std::size_t i = 0, asks = 0; i < all.size() && asks < kAsksAtOnce; i += kMostIdsPerMessage, ++asks) {
    write_id_ask(out_, store_.id(open_->layer), open_->salt, all.subspan(i));
    send_(open_->peer, out_);
  }
}

MessageFault Reconciler::on_message(RobotId from, mapper::ByteSpan message, hal::TimeNs now_ns) {
  if (message.empty()) return MessageFault::truncated;
  switch (static_cast<ReconcileKind>(message[0])) {
    case ReconcileKind::sketch_ask:
      return on_sketch_ask(from, message);
    case ReconcileKind::sketch:
      return on_sketch(from, message, now_ns);
    case ReconcileKind::id_ask:
      return on_id_ask(from, message);
    case ReconcileKind::records:
      return on_records(from, message, now_ns);
  }
  return MessageFault::unknown_kind;
}

// Most often one lacks what the other has, and nothing else: then the counts of records tell the difference, which
// takes at least 1.3 symbols each. From there on, or where the counts tell nothing, in steps that are small beside what
// there is: a symbol too many is one that is paid for.
std::uint32_t Reconciler::next_wanted() const {
  const std::int64_t ours = store_.record_count(open_->layer), theirs = answer_.sketch.header.items;
  const auto least_differences = static_cast<std::uint64_t>(std::abs(theirs - ours));
  const std::uint32_t wanted = open_->wanted_symbols;
  const std::uint32_t step = std::max(least_differences > 0 ? 1U : 2U, wanted / 48);
  const std::uint64_t least_symbols = least_differences + (least_differences < 64 ? 0 : least_differences * 3 / 10);
  return static_cast<std::uint32_t>(
      std::min<std::uint64_t>(std::max<std::uint64_t>(wanted + step, least_symbols), decoder_.most_symbols()));
}

// --- answering

MessageFault Reconciler::on_sketch_ask(RobotId from, mapper::ByteSpan message) {
  SketchAsk ask;
  if (const MessageFault fault = read_sketch_ask(message, ask); fault != MessageFault::none) return fault;
  const LayerIndex layer = store_.find(ask.layer);
  if (layer == kNoLayer || ask.count > kMostSymbolsPerMessage) return MessageFault::none;
  const std::span<const SketchSymbol> symbols = answering_.symbols(store_, layer, ask.salt, ask.first, ask.count);
  LayerPosition position{ask.layer, {}};
  for (const Lane lane : kAllLanes) position.had[static_cast<std::size_t>(lane)] = store_.had(layer, lane);
  const SketchHeader header{ask.salt, ask.first, store_.record_count(layer)};
  if (write_sketch_answer(out_, position, store_.content_hash(layer), header, symbols) > 0) send_(from, out_);
  return MessageFault::none;
}

MessageFault Reconciler::on_id_ask(RobotId from, mapper::ByteSpan message) {
  if (const MessageFault fault = read_id_ask(message, ids_); fault != MessageFault::none) return fault;
  const LayerIndex layer = store_.find(ids_.layer);
  if (layer == kNoLayer) return MessageFault::none;
  const auto end = ids_.ids.begin() + static_cast<std::ptrdiff_t>(ids_.count);
  std::sort(ids_.ids.begin(), end);
  begin_records(out_, ids_.layer);
  RecordKey last_key = 0;
  bool is_empty = true;
  store_.for_each(layer, [&](const StoredRecord& record) {
    if (!std::binary_search(ids_.ids.begin(), end, sketch_id(ids_.salt, record.key, record.version))) return;
    if (!add_loose_record(out_, store_, record, last_key)) {
      send_(from, out_);
      begin_records(out_, ids_.layer);
      last_key = 0;
      (void)add_loose_record(out_, store_, record, last_key);
    }
    is_empty = false;
  });
  if (!is_empty) send_(from, out_);
  return MessageFault::none;
}

// --- asking

MessageFault Reconciler::on_sketch(RobotId from, mapper::ByteSpan message, hal::TimeNs now_ns) {
  if (const MessageFault fault = read_sketch_answer(message, answer_); fault != MessageFault::none) return fault;
  if (!open_ || from != open_->peer || open_->knows_difference || answer_.sketch.header.salt != open_->salt ||
      answer_.position.id != store_.id(open_->layer)) {
    return MessageFault::none;
  }
  if (open_->their_content.value_or(answer_.content_hash) != answer_.content_hash ||
      store_.content_hash(open_->layer) != open_->our_content) {
    end(counts_.ended_changed);
    return MessageFault::none;
  }
  open_->their_content = answer_.content_hash;
  open_->their_position = answer_.position;
  open_->heard_ns = now_ns;
  const std::span<const SketchSymbol> theirs = answer_.sketch.used();
  const std::span<const SketchSymbol> ours = asking_.symbols(
      store_, open_->layer, open_->salt, answer_.sketch.header.first, static_cast<std::uint32_t>(theirs.size()));
  switch (decoder_.add(answer_.sketch.header.first, ours, theirs)) {
    case SketchState::wants_symbols:
      if (decoder_.taken_symbols() >= open_->wanted_symbols) {
        if (open_->wanted_symbols >= decoder_.most_symbols()) {
          refuse();
          return MessageFault::none;
        }
        open_->wanted_symbols = next_wanted();
        ask(now_ns);
      }
      return MessageFault::none;
    case SketchState::too_many_differences:
    case SketchState::contradictory:
      refuse();
      return MessageFault::none;
    case SketchState::complete:
      break;
  }
  open_->knows_difference = true;
  counts_.asked_symbols += decoder_.taken_symbols();
  counts_.differences += decoder_.only_peers().size() + decoder_.only_ours().size();
  lacking_.assign(decoder_.only_peers().begin(), decoder_.only_peers().end());
  if (lacking_.empty()) {
    end_equal();
  } else {
    ask(now_ns);
  }
  return MessageFault::none;
}

void Reconciler::take_record(const LooseRecord& record, hal::TimeNs now_ns) {
  const SketchId id = sketch_id(open_->salt, record.key, record.version);
  const auto it = std::lower_bound(lacking_.begin(), lacking_.end(), id);
  if (it == lacking_.end() || *it != id) return;
  const LayerStore::Put put = store_.put(open_->layer, record.key, record.version, record.lane, record.payload);
  if (put == LayerStore::Put::refused || put == LayerStore::Put::conflicting) return;
  lacking_.erase(it);
  ++counts_.recovered_records;
  open_->heard_ns = now_ns;
}

MessageFault Reconciler::on_records(RobotId from, mapper::ByteSpan message, hal::TimeNs now_ns) {
  LooseRecords records;
  if (const MessageFault fault = records.open(message); fault != MessageFault::none) return fault;
  if (!open_ || from != open_->peer || !open_->knows_difference || records.layer() != store_.id(open_->layer)) {
    return MessageFault::none;
  }
  const std::size_t before = lacking_.size();
  for (LooseRecord record; records.take(record);) take_record(record, now_ns);
  if (lacking_.empty()) {
    end_equal();
  } else if (lacking_.size() != before && lacking_.size() / kMostIdsPerMessage != before / kMostIdsPerMessage) {
    ask(now_ns);
  }
  return MessageFault::none;
}

void Reconciler::refuse() {
  // Too much is missing for this to be cheaper than asking for everything.
  store_.set_unclaimed(open_->layer, false);
  finish(counts_.ended_refused);
}

void Reconciler::end_equal() {
  store_.set_unclaimed(open_->layer, false);
  for (const Lane lane : kAllLanes) {
    const VersionRanges& theirs = open_->their_position.had[static_cast<std::size_t>(lane)];
    (void)store_.add_had(open_->layer, lane, {0, theirs.upto()});
    for (const VersionRange& range : theirs.beyond()) (void)store_.add_had(open_->layer, lane, range);
  }
  finish(counts_.ended_equal);
}

}  // namespace g3d::net
