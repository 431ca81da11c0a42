// SPDX-License-Identifier: Apache-2.0
// A robot of the fleet in wrong hands: what it seals is genuine, and its messages are anything. The input is a script
// of messages from three senders, which may start anew, and time. Whatever they say: our own layer stays ours, memory
// stays within its limits, and what we answer can be read by our own readers.
#include <algorithm>
#include <cstdlib>
#include <optional>

#include "net/gossip.hpp"

namespace {

using namespace g3d;
using namespace g3d::net;
using mapper::ByteSpan;

/// Longer scripts tell nothing more.
constexpr std::size_t kMaxInput_bytes = 4096;
constexpr StoreLimits kLimits{4, 64, 1U << 14, 64};
constexpr std::size_t kMostPeers = 2;
constexpr std::size_t kOwnRecords = 6;

void check(bool holds) {
  if (!holds) std::abort();
}

/// Reads what we say, as another robot would.
class Listener final : public Link {
 public:
  bool send(Address to, ByteSpan message) override {
    static LayerList layers;
    static WantedList wanted;
    static SketchAnswer answer;
    static IdAsk ids;
    check(!message.empty() && message.size() <= kMostMessage_bytes);
    std::uint64_t digest = 0;
    std::uint16_t number = 0;
    SeenNumbers seen;
    std::optional<SeenNumbers> told;
    bool wants = false;
    SketchAsk ask;
    MessageFault fault = MessageFault::unknown_kind;
    switch (message[0]) {
      case static_cast<std::uint8_t>(MessageKind::beacon):
        check(to == kEverybody);
        fault = read_beacon(message, digest, layers);
        break;
      case static_cast<std::uint8_t>(MessageKind::vector):
        fault = read_vector(message, wants, layers);
        break;
      case static_cast<std::uint8_t>(MessageKind::want):
        fault = read_want(message, seen, wanted);
        break;
      case static_cast<std::uint8_t>(MessageKind::wants):
        check(to == kEverybody);
        fault = read_wants(message, alias_of(RobotId{2}), told, wanted);
        break;
      case static_cast<std::uint8_t>(MessageKind::news):
        check(to == kEverybody);
        [[fallthrough]];
      case static_cast<std::uint8_t>(MessageKind::data):
        fault = read_data(message, number, nullptr);
        break;
      case static_cast<std::uint8_t>(ReconcileKind::sketch_ask):
        fault = read_sketch_ask(message, ask);
        break;
      case static_cast<std::uint8_t>(ReconcileKind::sketch):
        fault = read_sketch_answer(message, answer);
        break;
      case static_cast<std::uint8_t>(ReconcileKind::id_ask):
        fault = read_id_ask(message, ids);
        break;
      case static_cast<std::uint8_t>(ReconcileKind::records):
        fault = LooseRecords().open(message);
        break;
      default:
        break;
    }
    check(fault == MessageFault::none);
    return true;
  }
};

GossipOptions fixed_options() {
  GossipOptions options;
  options.self = {1, 1};
  options.most_peers = kMostPeers;
  options.reconciler.most_differences = 32;
  return options;
}

class Script {
 public:
  explicit Script(ByteSpan input) : input_(input) {
    for (std::uint8_t i = 0; i < kOwnRecords; ++i) {
      const std::uint8_t payload[3] = {i, 1, 2};
      check(gossip_.publish(block_record(0, 100U + i, Part::whole), kAllLanes[i % kLanes], payload));
    }
    gossip_.commit(now_ns_);
    own_hash_ = store_.content_hash(gossip_.own_layer());
  }

  void run() {
    while (const auto step = byte()) {
      const std::uint64_t who = *step % 4;
      if (*step >= 0xF0) {
        ++sessions_[who];
      } else if (who == 0) {
        now_ns_ += (*step >> 2) * 20 * hal::kMillisecond_ns;
        gossip_.on_time(now_ns_);
      } else {
        gossip_.on_message({who + 1, sessions_[who], 100 + who}, message(), now_ns_);
      }
      check(store_.content_hash(gossip_.own_layer()) == own_hash_ && gossip_.version() == kOwnRecords);
      check(store_.layer_count() <= kLimits.layers && store_.record_count() <= kLimits.records);
      check(gossip_.members().all().size() <= kMostPeers);
    }
  }

 private:
  std::optional<std::uint8_t> byte() {
    if (at_ >= input_.size()) return std::nullopt;
    return input_[at_++];
  }
  /// Two bytes say how long it is.
  ByteSpan message() {
    const std::size_t low = byte().value_or(0), high = byte().value_or(0);
    const std::size_t size = std::min((low | high << 8) % (kMostMessage_bytes + 8), input_.size() - at_);
    at_ += size;
    return input_.subspan(at_ - size, size);
  }

  const ByteSpan input_;
  std::size_t at_ = 0;
  Listener listener_;
  LayerStore store_{kLimits};
  Gossip gossip_{fixed_options(), store_, listener_};
  std::uint64_t sessions_[4] = {1, 1, 1, 1};
  std::uint64_t own_hash_ = 0;
  hal::TimeNs now_ns_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  if (size_bytes > kMaxInput_bytes) return -1;
  Script({data, size_bytes}).run();
  return 0;
}
