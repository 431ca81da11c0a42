// SPDX-License-Identifier: Apache-2.0
// Makes two robots hold the same records of a layer where their versions do not tell who lacks what: after a restart
// that kept records but not what they complete, or when a writer died between two robots. Costs in proportion to what
// differs, not to what they hold (set_sketch.hpp).
//
//   sketch ask ──▶  ◀── symbols, more and more of them, until the difference is known
//   id ask ──▶      ◀── records, until none is missing; then we have what it had, and say so
//
// One exchange at a time of our own; answers others without remembering anything. Lost messages are asked for again.
// If anything of the layer changes on either side meanwhile, the exchange ends and somebody begins another one later.
// Nothing is allocated after construction. One thread.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "hal/messages.hpp"
#include "net/layer_store.hpp"
#include "net/membership.hpp"
#include "net/reconcile_message.hpp"
#include "net/sketch_cache.hpp"

namespace g3d::net {

struct ReconcilerOptions {
  std::uint32_t most_differences = 8192;
  std::uint32_t first_symbols =
      1;  ///< asked for at first: it tells how many records the other one has, see next_wanted
  hal::TimeNs ask_again_ns = 250'000'000;  ///< where an answer is missing
  hal::TimeNs give_up_ns = 5'000'000'000;  ///< without anything new
  std::uint64_t seed = 0;
};

struct ReconcilerCounts {
  std::uint64_t opened = 0;
  std::uint64_t ended_equal = 0;    ///< we hold all that the other held
  std::uint64_t ended_changed = 0;  ///< something changed meanwhile
  std::uint64_t ended_refused = 0;  ///< too many differences
  std::uint64_t ended_silent = 0;
  std::uint64_t asked_symbols = 0;  ///< of exchanges that found the difference
  std::uint64_t differences = 0;    ///< the same
  std::uint64_t recovered_records = 0;
};

class Reconciler {
 public:
  /// Sends a message to a robot.
  using Send = std::function<void(RobotId to, const WireWriter& message)>;

  Reconciler(const ReconcilerOptions& options, LayerStore& store, Send send);

  [[nodiscard]] bool is_busy() const { return open_.has_value(); }
  [[nodiscard]] bool is_about(LayerIndex layer) const { return open_ && open_->layer == layer; }
  void begin(RobotId peer, LayerIndex layer, hal::TimeNs now_ns);
  /// Asks again, or gives up.
  void on_time(hal::TimeNs now_ns);
  /// A message of a ReconcileKind.
  [[nodiscard]] MessageFault on_message(RobotId from, mapper::ByteSpan message, hal::TimeNs now_ns);
  /// The last exchange that need not be repeated: we hold all that the peer held then, or it is not to be had this way.
  /// Nothing if it was taken already; one that was broken off leaves none.
  struct Finished {
    RobotId peer = 0;
    LayerIndex layer = kNoLayer;
    std::uint64_t their_content = 0;
  };
  [[nodiscard]] std::optional<Finished> take_finished() { return std::exchange(finished_, std::nullopt); }
  [[nodiscard]] const ReconcilerCounts& counts() const { return counts_; }

 private:
  struct Exchange {
    RobotId peer = 0;
    LayerIndex layer = kNoLayer;
    SketchSalt salt;
    std::uint64_t our_content = 0;
    std::optional<std::uint64_t> their_content;
    LayerPosition their_position;
    std::uint32_t wanted_symbols = 0;  ///< so many in all
    bool knows_difference = false;
    hal::TimeNs asked_ns = 0;
    hal::TimeNs heard_ns = 0;
  };
  [[nodiscard]] MessageFault on_sketch_ask(RobotId from, mapper::ByteSpan message);
  [[nodiscard]] MessageFault on_sketch(RobotId from, mapper::ByteSpan message, hal::TimeNs now_ns);
  [[nodiscard]] MessageFault on_id_ask(RobotId from, mapper::ByteSpan message);
  [[nodiscard]] MessageFault on_records(RobotId from, mapper::ByteSpan message, hal::TimeNs now_ns);
  void ask(hal::TimeNs now_ns);
  void ask_for_symbols(std::uint32_t first, std::uint32_t end);
  void ask_for_records();
  void finish(std::uint64_t& count) {
    finished_ = Finished{open_->peer, open_->layer, open_->their_content.value_or(0)};
    end(count);
  }
  void end(std::uint64_t& count) {
    ++count;
    open_.reset();
  }
  void refuse();
  void end_equal();
  [[nodiscard]] std::uint32_t next_wanted() const;
  void take_record(const LooseRecord& record, hal::TimeNs now_ns);

  ReconcilerOptions options_;
  LayerStore& store_;
  Send send_;
  ReconcilerCounts counts_;
  SketchDecoder decoder_;
  std::optional<Exchange> open_;
  std::optional<Finished> finished_;
  std::vector<SketchId> lacking_;  ///< ascending; reserved
  std::uint64_t exchanges_ = 0;
  WireWriter out_;
  SketchAnswer answer_;
  IdAsk ids_;
  SketchCache asking_, answering_;
};

}  // namespace g3d::net
