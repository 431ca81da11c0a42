// SPDX-License-Identifier: Apache-2.0
#include "main_network.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

#include "mapper/mapper.hpp"
#include "mapper/summary.hpp"
#include "net/broker_options.hpp"
#include "net/fleet_key_file.hpp"
#include "net/robot_identity.hpp"

namespace g3d {
namespace {

constexpr std::size_t kMostFleetSubmaps = 64;
/// Where robots share theirs, with --loops: at most 64 each before old ones are joined. What is not there has address
/// space alone, but of that some kernels give a process no more than 512 GB.
constexpr std::size_t kMostLoopedSubmaps = 192;
constexpr hal::TimeNs kFleetLook_ns = 50'000'000;
/// So often in a row all have to hold the same: by then they have heard it from us as well.
constexpr int kFleetSettled = 3;

hal::Result<net::RobotId> robot_id(const board::Board& board) {
  if (board.network_robot == "auto") return net::machine_robot_id();
  const auto robot = net::parse_robot_id(board.network_robot);
  if (robot && *robot != 0) return *robot;
  return hal::Error{hal::Reason::bad_usage,
                    fmt::format("network.robot, --robot: '{}' is no robot's id: auto, or 1 to 16 hexadecimal digits, "
                                "not all of them 0",
                                board.network_robot)};
}

std::vector<std::string> split_peers(const std::string& text) {
  std::vector<std::string> peers;
  if (text == "none") return peers;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    peers.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return peers;
}

hal::Pose T_world_map(const board::Board& board) {
  return hal::from_xyz_rpy(board.network_x_m, board.network_y_m, 0.0, 0.0, 0.0,
                           board.network_yaw_deg * std::numbers::pi / 180.0);
}

}  // namespace

hal::Result<void> set_network(const NetworkOptions& options, board::Board& board) {
  if (options.key) board.network_key = *options.key;
  if (options.keep) board.network_keep = *options.keep;
  if (options.robot) board.network_robot = *options.robot;
  if (options.port) board.network_port = *options.port;
  std::string peers;
  for (const std::string& peer : options.peers) peers += (peers.empty() ? "" : ",") + peer;
  if (!peers.empty()) board.network_peers = peers;
  const bool says_more = options.robot || options.port || options.settle_s || options.keep || !peers.empty();
  if (!has_fleet(board) && says_more) {
    return hal::Error{
        hal::Reason::bad_usage,
        "--robot, --port, --peer, --keep and --settle are for robots of a fleet; give its --key FILE as well, or "
        "network.key in the board file"};
  }
  return {};
}

hal::Result<FleetPlan> plan_fleet(const board::Board& board, bool has_map, bool has_loops) {
  FleetPlan plan;
  const auto robot = robot_id(board);
  if (!robot) return robot.error();
  auto keys = net::read_fleet_key(board.network_key);
  if (!keys) return keys.error();
  plan.keys = std::move(keys).value();
  if (plan.keys.has_revoked(robot.value())) {
    return hal::Error{hal::Reason::bad_usage,
                      fmt::format("{}: robot {} is revoked there: nobody would listen to it. Give it another id",
                                  board.network_key, net::text_of_robot(robot.value()))};
  }
  plan.port.port = static_cast<std::uint16_t>(board.network_port);
  plan.port.group_port = static_cast<std::uint16_t>(board.network_group_port);
  plan.port.multicast = board.network_group != "none";
  if (plan.port.multicast) plan.port.group = board.network_group;
  if (board.network_interface != "auto") plan.port.interface = board.network_interface;
  plan.port.peers = split_peers(board.network_peers);

  if (board.network_keep != "none") plan.keep = board.network_keep;
  net::SharingThreadOptions& thread = plan.sharing;
  thread.has_map = has_map;
  thread.key_path = board.network_key;
  net::SharingOptions& sharing = thread.sharing;
  sharing.gossip.self = {robot.value(), net::fresh_incarnation()};
  sharing.gossip.seed = net::mixed(sharing.gossip.self);
  plan.radio_bandwidth_Bps = 1000.0 * board.network_bandwidth_kBps;
  if (board.network_broker != "none") {
    auto broker = net::broker_options({board.network_broker, board.network_broker_topic, board.network_broker_login},
                                      robot.value());
    if (!broker) return broker.error();
    plan.broker = std::move(broker).value();
    plan.broker_bandwidth_Bps = 1000.0 * board.network_broker_bandwidth_kBps;
  }
  // Each way has its own limit besides.
  sharing.gossip.bandwidth_Bps = plan.radio_bandwidth_Bps + plan.broker_bandwidth_Bps;
  sharing.T_world_map = T_world_map(board);
  // Every start with --keep begins a submap.
  sharing.is_chain = has_loops;
  sharing.most_submaps = has_loops || !has_map ? kMostLoopedSubmaps : kMostFleetSubmaps;
  // The board says where the map begins as well as somebody has measured it.
  if (has_map) sharing.refine.emplace();
  if (!has_map) {
    // It has nothing else to do with its memory, and must not be the one that forgets.
    sharing.store.records *= 4;
    sharing.store.payload_bytes *= 8;
  }
  return plan;
}

hal::Result<std::unique_ptr<Fleet>> Fleet::open(FleetPlan plan, const mapper::VoxelMap& own, hal::Clock& clock) {
  auto port = net::UdpPort::open(plan.port);
  if (!port) return port.error();
  std::unique_ptr<net::MqttPort> broker;
  if (plan.broker) {
    auto opened = net::MqttPort::open(*plan.broker);
    if (!opened) return opened.error();
    broker = std::move(opened).value();
  }
  std::unique_ptr<net::KeptLayers> kept;
  if (!plan.keep.empty()) {
    net::KeeperOptions keeper;
    keeper.folder = plan.keep;
    keeper.robot = plan.sharing.sharing.gossip.self.robot;
    keeper.dropped = plan.keys.dropped;
    auto opened = net::KeptLayers::open(keeper, plan.sharing.sharing.store);
    if (!opened) return opened.error();
    kept = std::move(opened).value();
  }
  return std::unique_ptr<Fleet>(
      new Fleet(std::move(plan), std::move(port).value(), std::move(broker), std::move(kept), own, clock));
}

Fleet::Fleet(FleetPlan plan, std::unique_ptr<net::UdpPort> port, std::unique_ptr<net::MqttPort> broker,
             std::unique_ptr<net::KeptLayers> kept, const mapper::VoxelMap& own, hal::Clock& clock)
    : clock_(clock), own_(own), port_(std::move(port)), broker_(std::move(broker)), mux_([&] {
        std::vector<net::PortMux::Branch> branches{{port_.get(), plan.radio_bandwidth_Bps}};
        if (broker_) branches.push_back({broker_.get(), plan.broker_bandwidth_Bps});
        return branches;
      }()) {
  const auto wait = [this](hal::TimeNs at_most_ns) {
    (void)port_->wait(at_most_ns);
    mux_.on_time(clock_.now());
  };
  net::SharingParts parts{mux_, wait, clock, own};
  parts.on_key = [path = plan.sharing.key_path](const hal::Error* error, std::uint16_t epoch) {
    if (error != nullptr) {
      fmt::print(stderr, "g3dmap: {}; the key of epoch {} stays in use\n", error->text, epoch);
    } else {
      fmt::print(stderr, "g3dmap: {}: the key of epoch {} is in use from now on\n", path, epoch);
    }
  };
  parts.on_round = [this](net::MapSharing& sharing, hal::TimeNs now_ns) {
    if (team_ != nullptr) team_->on_round(sharing, now_ns);
    if (loops_ == nullptr || !sharing.is_chain_due(now_ns) || !loops_->try_borrow_chain()) return;
    sharing.publish_chain(loops_->chain(), now_ns);
    loops_->give_back_chain();
  };
  thread_ = std::make_unique<net::SharingThread>(plan.sharing, std::move(plan.keys), parts, std::move(kept));
}

void Fleet::speak_for(nav::TeamLink& link, const hal::Latest<nav::LiveStatus>& status) {
  team_ = std::make_unique<net::TeamPart>(link, status, static_cast<float>(hal::kobuki::kBodyRadius_m));
}

void Fleet::stop() {
  thread_->stop();
  const net::LayerKeeper* keeper = thread_->sharing().keeper();
  if (keeper == nullptr) return;
  if (const auto trouble = keeper->trouble()) {
    fmt::print(stderr, "g3dmap: {}; what was not kept, other robots give back after the next start\n", trouble->text);
  }
}

void Fleet::settle(double most_s, const std::function<bool()>& is_given_up) {
  const hal::TimeNs begin_ns = clock_.now();
  const hal::TimeNs end_ns = begin_ns + static_cast<hal::TimeNs>(most_s * 1e9);
  std::uint64_t seen = thread_->brief().generation();
  net::SharingBrief brief;
  int settled = 0;
  while (settled < kFleetSettled && clock_.now() < end_ns && !is_given_up()) {
    clock_.sleep_until(clock_.now() + kFleetLook_ns);
    if (!thread_->brief().read_newer(seen, brief)) continue;
    settled = brief.is_told ? settled + 1 : 0;
    if (brief.alive == 0 && brief.is_told) break;  // nobody is there to be told
  }
}

std::optional<std::string> Fleet::answer(std::string_view request) {
  if (request != "peers" && request != "peers text") return std::nullopt;
  const auto status = thread_->ask();
  if (!status) return "{\"error\": \"it is too busy to answer within two seconds; ask again\"}\n";
  return request == "peers" ? net::to_json(*status) : net::to_text(*status);
}

std::unique_ptr<net::MergedMap> Fleet::whole_map() const {
  const net::MapSharing& sharing = thread_->sharing();
  net::MergedOptions options;
  options.grid = own_.grid();
  options.merged = own_.capacity();
  options.submap = own_.capacity();
  options.most_submaps = kMostLoopedSubmaps;
  auto merged = std::make_unique<net::MergedMap>(options);
  merged->take_all(sharing.store());
  return merged;
}

std::string Fleet::warning() const {
  if (const std::uint64_t refused = thread_->sharing().others().counts().refused_submaps; refused > 0) {
    return fmt::format(
        "this robot has no room for more than {} submaps of others, and was told {} times of one more: it has not "
        "driven "
        "by these; give --loops to all robots or to none",
        thread_->sharing().others().submap_count(), refused);
  }
  const std::size_t others = net::layers_of_other_grids(thread_->status());
  if (others == 0) return {};
  return fmt::format(
      "{} layers of other robots have voxels of another size and are not merged; give all robots one map.resolution_m",
      others);
}

void Fleet::write(mapper::JsonWriter& json, const std::string& merged_hash, double run_s) const {
  const net::MapSharing& sharing = thread_->sharing();
  const net::FleetStatus status = thread_->status();
  const auto rate = [&](std::uint64_t bytes) {
    return run_s > 0.0 ? std::round(static_cast<double>(bytes) / run_s) : 0.0;
  };
  json.member("id", net::text_of_robot(status.self.robot)).member("merged_hash", merged_hash);
  json.key("sharing").begin_object().member("layer", net::text_of_layer(status.self));
  json.member("keeps_layers", sharing.keeper() != nullptr)
      .member("key_epoch", status.epoch)
      .member("rejected_key_files", status.rejected_keys);
  json.member("layers_of_another_resolution", net::layers_of_other_grids(status));
  json.member("layers", status.layers.size()).member("records", sharing.store().record_count());
  json.member("payload_bytes", sharing.store().payload_bytes());
  json.member("published_blocks", sharing.writer().counts().published_blocks);
  json.member("published_bytes", sharing.writer().counts().published_bytes);
  if (loops_ != nullptr) {
    const net::ChainCounts& chain = sharing.chain_writer().counts();
    json.key("shared_submaps").begin_object().member("published", chain.published_submaps);
    json.member("published_blocks", chain.published_blocks).member("published_bytes", chain.published_bytes);
    json.member("published_poses", chain.published_poses).member("retracted", chain.retracted_submaps);
    json.member("refused", chain.refused_submaps).end_object();
  }
  json.member("sent_bytes", status.radio.sent_bytes).member("sent_Bps", rate(status.radio.sent_bytes));
  json.member("received_bytes", status.radio.received_bytes);
  json.member("stored_records", status.gossip.stored_records);
  json.member("superseded_records", status.gossip.superseded_records);
  json.member("refused_records", status.gossip.refused_records);
  json.member("refused_submaps", sharing.others().counts().refused_submaps);
  json.member("refused_blocks", sharing.others().counts().refused_blocks + thread_->view_refused_blocks());
  json.member("round_p50_us", thread_->round_times().percentile_us(0.5));
  json.member("round_p99_us", thread_->round_times().percentile_us(0.99));
  json.member("round_max_us", thread_->round_times().max_us());
  json.key("refused_datagrams").begin_object();
  for (std::size_t i = 0; i < net::kGateRefusalCount; ++i) {
    if (status.gate.by_reason[i] > 0) {
      json.member(net::to_string(static_cast<net::GateRefusal>(i)), status.gate.by_reason[i]);
    }
  }
  json.end_object();
  if (broker_) {
    const net::MqttPortCounts counts = broker_->counts();
    json.key("broker").begin_object().member("connections", counts.connections);
    json.member("failed_connections", counts.failed_connections).member("last_fault", broker_->last_fault());
    json.member("sent_datagrams", counts.sent_datagrams).member("sent_messages", counts.sent_messages);
    json.member("sent_bytes", counts.sent_message_bytes).member("received_datagrams", counts.received_datagrams);
    json.key("dropped").begin_object();
    for (std::size_t i = 0; i < net::kMqttDrops; ++i) {
      if (counts.drops[i] > 0) json.member(net::to_string(static_cast<net::MqttDrop>(i)), counts.drops[i]);
    }
    json.end_object().end_object();
  }
  json.end_object();
  json.key("robots").begin_array();
  for (const net::PeerStatus& peer : status.peers) {
    json.begin_object().member("id", net::text_of_robot(peer.robot)).member("state", net::to_string(peer.state));
    json.member("holds_the_same", peer.holds_the_same).end_object();
  }
  json.end_array();
}

std::string brief_text(const net::SharingBrief& brief) {
  return fmt::format("{} robot{}, {} layer{}, {}", brief.alive, brief.alive == 1 ? "" : "s", brief.layers,
                     brief.layers == 1 ? "" : "s", mapper::readable_bytes(brief.payload_bytes));
}

}  // namespace g3d
