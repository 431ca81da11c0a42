// SPDX-License-Identifier: Apache-2.0
#include "net/fleet_status.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>

#include "mapper/json_writer.hpp"
#include "mapper/summary.hpp"
#include "net/port_mux.hpp"
#include "net/robot_identity.hpp"
#include "net/udp_port.hpp"

namespace g3d::net {
namespace {

/// Each takes up to 320 bytes of JSON.
constexpr std::size_t kMostStatusLines = 240;

Version lowest_of(const LaneVersions& lanes) { return *std::min_element(lanes.begin(), lanes.end()); }

/// What we hold of a layer beyond what a peer has; `left` is how many records may still be looked at.
void count_lacking(const LayerStore& store, LayerIndex layer, const LaneVersions& has, std::uint32_t& left,
                   PeerLayerStatus& status) {
  for (const Lane lane : kAllLanes) {
    auto record = store.first_after(layer, lane, has[static_cast<std::size_t>(lane)]);
    for (; record && left > 0; record = store.first_after(layer, lane, record->version)) {
      --left;
      ++status.lacks_records;
      status.lacks_bytes += record->bytes;
    }
    status.is_at_least = status.is_at_least || record.has_value();
  }
}

PeerStatus status_of(const LayerStore& store, const Peer& peer, std::uint32_t& left, hal::TimeNs now_ns) {
  PeerStatus status{peer.robot,
                    peer.state,
                    peer.address,
                    static_cast<double>(now_ns - peer.heard_ns) * 1e-9,
                    peer.digest != 0 && peer.digest == store.digest(),
                    {}};
  for (LayerIndex layer = 0; layer < store.layer_count(); ++layer) {
    PeerLayerStatus of;
    of.id = store.id(layer);
    const KnownLayer& known = peer.known[layer];
    const Version ours = store.highest(layer);
    if (ours == 0 && known.highest == 0) continue;  // nobody has anything of it
    of.is_told = status.holds_the_same || known.highest > 0;
    of.upto = status.holds_the_same ? ours : lowest_of(known.upto);
    of.highest = status.holds_the_same ? ours : known.highest;
    of.is_ahead = of.highest > ours;
    if (!status.holds_the_same) count_lacking(store, layer, known.upto, left, of);
    status.layers.push_back(of);
  }
  return status;
}

/// Behind a mux the fleet's radio is the first port, a broker the second.
std::string address_text(Address address) {
  const Address within = PortMux::within_branch(address);
  return address >> 56U == 2 ? fmt::format("site {:x}", within) : UdpPort::text_of(within);
}

std::string old_key_text(const FleetStatus& status) {
  if (!status.hears_old_key) return "";
  return status.hears_stragglers ? ", a rotation is under way: robots without the new key were heard"
                                 : ", a rotation is under way: nobody without the new key was heard of late";
}

std::string lacking_text(const PeerLayerStatus& layer) {
  std::string text =
      layer.is_told ? fmt::format("{:>9} {:>9}  ", layer.upto, layer.highest) : fmt::format("{:>9} {:>9}  ", "?", "?");
  if (layer.lacks_records == 0) {
    text += "all that is here";
  } else {
    text += fmt::format("lacks {}{} records, {}", layer.is_at_least ? "at least " : "", layer.lacks_records,
                        mapper::readable_bytes(layer.lacks_bytes));
  }
  return text + (layer.is_ahead ? ", has newer ones" : "");
}

bool is_of_another_grid(const LayerStatus& layer, const FleetStatus& status) {
  return layer.resolution_m && *layer.resolution_m != status.resolution_m;
}

/// 0.05 as 0.05, not as what is nearest to it in twice as many bits.
double shortest(float value) { return std::stod(fmt::format("{}", value)); }

}  // namespace

FleetStatus fleet_status(const MapSharing& sharing, const DatagramGate& gate, const FleetRadio& radio,
                         std::uint64_t rejected_keys, hal::TimeNs now_ns) {
  FleetStatus status;
  const LayerStore& store = sharing.store();
  status.self = sharing.gossip().options().self;
  status.resolution_m = sharing.others().map().grid().resolution_m;
  status.digest = store.digest();
  status.bytes = store.payload_bytes();
  for (LayerIndex layer = 0; layer < store.layer_count(); ++layer) {
    status.layers.push_back({store.id(layer), lowest_of(store.upto(layer)), store.highest(layer),
                             store.record_count(layer), resolution_of(store, layer)});
  }
  std::uint32_t left = kMostCountedRecords;
  for (const Peer& peer : sharing.gossip().members().all()) {
    status.peers.push_back(status_of(store, peer, left, now_ns));
  }
  std::sort(status.peers.begin(), status.peers.end(),
            [](const PeerStatus& a, const PeerStatus& b) { return a.robot < b.robot; });
  status.epoch = gate.keys().epoch;
  status.hears_old_key = gate.keys().previous.has_value();
  status.hears_stragglers = gate.hears_stragglers(now_ns);
  status.rejected_keys = rejected_keys;
  status.gate = gate.counts();
  status.radio = radio.counts();
  status.gossip = sharing.gossip().counts();
  return status;
}

std::size_t layers_of_other_grids(const FleetStatus& status) {
  return static_cast<std::size_t>(std::ranges::count_if(
      status.layers, [&](const LayerStatus& layer) { return is_of_another_grid(layer, status); }));
}

const char* to_string(PeerState state) {
  switch (state) {
    case PeerState::alive:
      return "alive";
    case PeerState::suspect:
      return "suspect";
    case PeerState::gone:
      break;
  }
  return "gone";
}

std::string to_json(const FleetStatus& status) {
  mapper::JsonWriter json;
  std::size_t lines = 0;
  std::size_t left_out = 0;
  json.begin_object().member("id", text_of_robot(status.self.robot)).member("layer", text_of_layer(status.self));
  json.member("digest", fmt::format("{:016x}", status.digest));
  json.key("key").begin_object().member("epoch", status.epoch).member("hears_old_key", status.hears_old_key);
  json.member("stragglers", status.hears_stragglers).member("rejected_files", status.rejected_keys).end_object();
  json.member("bytes", status.bytes).key("layers").begin_array();
  for (const LayerStatus& layer : status.layers) {
    json.begin_object().member("layer", text_of_layer(layer.id)).member("upto", layer.upto);
    json.member("highest", layer.highest).member("records", layer.records);
    if (is_of_another_grid(layer, status)) json.member("other_resolution_m", shortest(*layer.resolution_m));
    json.end_object();
  }
  json.end_array().key("robots").begin_array();
  for (const PeerStatus& peer : status.peers) {
    json.begin_object().member("id", text_of_robot(peer.robot)).member("state", to_string(peer.state));
    json.member("address", address_text(peer.address)).member("heard_s", std::round(peer.heard_s * 100.0) / 100.0);
    json.member("holds_the_same", peer.holds_the_same).key("layers").begin_array();
    for (const PeerLayerStatus& layer : peer.layers) {
      if (++lines > kMostStatusLines) {
        ++left_out;
        continue;
      }
      json.begin_object().member("layer", text_of_layer(layer.id)).member("told", layer.is_told);
      json.member("upto", layer.upto).member("highest", layer.highest).member("ahead", layer.is_ahead);
      json.member("lacks_records", layer.lacks_records).member("lacks_bytes", layer.lacks_bytes);
      json.member("lacks_more", layer.is_at_least).end_object();
    }
    json.end_array().end_object();
  }
  json.end_array().member("lines_left_out", left_out);
  json.key("datagrams").begin_object().member("sent", status.radio.sent).member("sent_bytes", status.radio.sent_bytes);
  json.member("received", status.radio.received).member("received_bytes", status.radio.received_bytes);
  json.member("delivered", status.gate.delivered).key("refused").begin_object();
  for (std::size_t i = 0; i < kGateRefusalCount; ++i) {
    if (status.gate.by_reason[i] > 0) json.member(to_string(static_cast<GateRefusal>(i)), status.gate.by_reason[i]);
  }
  json.end_object().end_object().end_object();
  return json.take();
}

std::string to_text(const FleetStatus& status) {
  std::string text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "robot {}, key of epoch {}{}\n", text_of_robot(status.self.robot), status.epoch,
                 old_key_text(status));
  if (status.rejected_keys > 0) fmt::format_to(out, "the key's file was bad {} times\n", status.rejected_keys);
  fmt::format_to(out, "\nheld here, {:<17}  up to   highest   records\n", mapper::readable_bytes(status.bytes));
  for (const LayerStatus& layer : status.layers) {
    fmt::format_to(out, "  {} {:>9} {:>9} {:>9}{}\n", text_of_layer(layer.id), layer.upto, layer.highest, layer.records,
                   layer.id == status.self ? "  its own" : "");
    if (is_of_another_grid(layer, status)) {
      fmt::format_to(out,
                     "    its voxels are {} m, ours {} m: it is not merged; give all robots one map.resolution_m\n",
                     *layer.resolution_m, status.resolution_m);
    }
  }
  std::size_t lines = 0;
  std::size_t left_out = 0;
  for (const PeerStatus& peer : status.peers) {
    fmt::format_to(out, "\nrobot {}  {}  {}  heard {:.1f} s ago{}\n", text_of_robot(peer.robot), to_string(peer.state),
                   address_text(peer.address), peer.heard_s, peer.holds_the_same ? "  holds the same" : "");
    for (const PeerLayerStatus& layer : peer.layers) {
      if (++lines > kMostStatusLines) {
        ++left_out;
      } else {
        fmt::format_to(out, "  {} {}\n", text_of_layer(layer.id), lacking_text(layer));
      }
    }
  }
  if (status.peers.empty()) text += "\nno other robot was heard\n";
  if (left_out > 0) fmt::format_to(out, "\n{} lines are left out\n", left_out);
  fmt::format_to(out, "\ndatagrams: {} sent ({}), {} received ({}), {} delivered, {} refused\n", status.radio.sent,
                 mapper::readable_bytes(status.radio.sent_bytes), status.radio.received,
                 mapper::readable_bytes(status.radio.received_bytes), status.gate.delivered, status.gate.refused());
  for (std::size_t i = 0; i < kGateRefusalCount; ++i) {
    if (status.gate.by_reason[i] == 0) continue;
    fmt::format_to(out, "  refused {:>9}  {}\n", status.gate.by_reason[i], to_string(static_cast<GateRefusal>(i)));
  }
  return text;
}

}  // namespace g3d::net
