// SPDX-License-Identifier: Apache-2.0
#include "net/sharing_thread.hpp"

#include <pthread.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "hal/linux/cpu_time.hpp"

namespace g3d::net {
namespace {

constexpr hal::TimeNs kSharingTell_ns = 500'000'000;
constexpr auto kSharingPatience = std::chrono::milliseconds(2000);
constexpr auto kSharingLook = std::chrono::milliseconds(2);

GateSettings gate_settings(const SharingThreadOptions& options) {
  GateSettings settings;
  settings.robot = options.sharing.gossip.self.robot;
  settings.incarnation = options.sharing.gossip.self.incarnation;
  settings.most_sessions = options.most_sessions;
  return settings;
}

/// Who has written before goes on as the same.
SharingThreadOptions as_kept(SharingThreadOptions options, const KeptLayers* kept) {
  if (kept != nullptr && kept->keeper != nullptr) options.sharing.gossip.self = kept->keeper->self();
  return options;
}

}  // namespace

SharingThread::SharingThread(const SharingThreadOptions& options, FleetKey keys, const SharingParts& parts,
                             std::unique_ptr<KeptLayers> kept)
    : options_(as_kept(options, kept.get())),
      parts_(parts),
      gate_(std::move(keys), gate_settings(options_)),
      radio_(gate_, parts.port),
      sharing_(options_.sharing, parts.own, radio_, std::move(kept)),
      view_(parts.own) {
  if (!options.key_path.empty()) key_file_.emplace(options.key_path, options.key_period_ns);
  sharing_.drop(gate_.keys().dropped);
}

SharingThread::~SharingThread() { stop(); }

void SharingThread::start() {
  if (ending_.load(std::memory_order_relaxed) || thread_.joinable()) return;
  thread_ = std::thread([this] { loop(); });
}

void SharingThread::stop() {
  ending_.store(true, std::memory_order_release);
  if (thread_.joinable()) thread_.join();
}

void SharingThread::loop() {
  (void)pthread_setname_np(pthread_self(), "sharing");
  while (!ending_.load(std::memory_order_acquire)) {
    parts_.wait(options_.wait_ns);
    const hal::TimeNs now_ns = parts_.clock.now();
    round(now_ns);
    round_times_.add(parts_.clock.now() - now_ns);
  }
  tell(parts_.clock.now());
  sharing_.close();
  cpu_ns_ = hal::thread_cpu_ns();
}

void SharingThread::round(hal::TimeNs now_ns) {
  look_at_key(now_ns);
  if (options_.has_map && !has_told_pose_) {
    has_told_pose_ = sharing_.publish_pose(options_.sharing.T_world_map, now_ns);
  }
  (void)radio_.receive(
      now_ns, [&](const Sender& sender, mapper::ByteSpan message) { sharing_.on_message(sender, message, now_ns); });
  const std::span<const mapper::BlockKey> changed = sharing_.on_time_apart(now_ns);
  if (options_.has_map) view_.offer(changed, sharing_.others().map());
  if (parts_.on_round) parts_.on_round(sharing_, now_ns);
  if (asking_.load(std::memory_order_acquire) == Asking::asked) answer(now_ns);
  if (now_ns - told_ns_ >= kSharingTell_ns) tell(now_ns);
}

void SharingThread::look_at_key(hal::TimeNs now_ns) {
  if (!key_file_) return;
  auto changed = key_file_->look(now_ns);
  if (!changed) return;
  const std::uint16_t before = gate_.keys().epoch;
  if (changed->ok()) {
    gate_.use_keys(std::move(*changed).value());
    sharing_.drop(gate_.keys().dropped);
  }
  rejected_keys_.store(key_file_->rejected(), std::memory_order_relaxed);
  if (!parts_.on_key) return;
  if (!changed->ok()) {
    parts_.on_key(&changed->error(), before);
  } else if (gate_.keys().epoch != before) {
    parts_.on_key(nullptr, gate_.keys().epoch);
  }
}

FleetStatus SharingThread::status() const {
  return fleet_status(sharing_, gate_, radio_, rejected_keys_.load(std::memory_order_relaxed), parts_.clock.now());
}

void SharingThread::answer(hal::TimeNs now_ns) {
  status_ = fleet_status(sharing_, gate_, radio_, rejected_keys_.load(std::memory_order_relaxed), now_ns);
  asking_.store(Asking::answered, std::memory_order_release);
}

std::optional<FleetStatus> SharingThread::ask() {
  // An answer that came too late for whoever asked is outdated by now. While the thread is still at it, it is waited
  // for.
  if (asking_.load(std::memory_order_acquire) != Asking::asked) {
    asking_.store(Asking::asked, std::memory_order_release);
  }
  const auto until = std::chrono::steady_clock::now() + kSharingPatience;
  while (asking_.load(std::memory_order_acquire) != Asking::answered) {
    if (std::chrono::steady_clock::now() >= until) return std::nullopt;
    std::this_thread::sleep_for(kSharingLook);
  }
  FleetStatus status = std::move(status_);
  asking_.store(Asking::nobody, std::memory_order_release);
  return status;
}

void SharingThread::tell(hal::TimeNs now_ns) {
  told_ns_ = now_ns;
  const LayerStore& store = sharing_.store();
  SharingBrief brief;
  const WriterCounts& writer = sharing_.writer().counts();
  bool all_hold_the_same = true;
  for (const Peer& peer : sharing_.gossip().members().all()) {
    switch (peer.state) {
      case PeerState::alive:
        ++brief.alive;
        all_hold_the_same = all_hold_the_same && peer.digest == store.digest();
        break;
      case PeerState::suspect:
        ++brief.suspect;
        break;
      case PeerState::gone:
        ++brief.gone;
        break;
    }
  }
  brief.is_told = all_hold_the_same && writer.published_blocks == told_writer_.published_blocks &&
                  writer.refused_blocks == told_writer_.refused_blocks &&
                  writer.put_off_blocks == told_writer_.put_off_blocks;
  const ChainCounts& chain = sharing_.chain_writer().counts();
  brief.is_told = brief.is_told && sharing_.chain_writer().is_up_to_date() && chain == told_chain_;
  told_writer_ = writer;
  told_chain_ = chain;
  brief.layers = store.layer_count();
  brief.records = store.record_count();
  brief.payload_bytes = store.payload_bytes();
  brief.sent_bytes = radio_.counts().sent_bytes;
  brief.refused_datagrams = gate_.counts().refused();
  brief.epoch = gate_.keys().epoch;
  brief.digest = store.digest();
  brief.stamp_ns = now_ns;
  brief_.write(brief);
}

}  // namespace g3d::net
