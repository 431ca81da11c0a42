// SPDX-License-Identifier: Apache-2.0
#include "net/status_book.hpp"

#include <algorithm>

#include "net/wire_parts.hpp"

namespace g3d::net {

StatusBook::StatusBook(RobotId self, std::size_t most_robots) : self_(self), payload_(kMostPayload_bytes) {
  robots_.reserve(most_robots);
}

const RobotWords* StatusBook::find(RobotId robot) const {
  const auto it =
      std::find_if(robots_.begin(), robots_.end(), [&](const RobotWords& w) { return w.layer.robot == robot; });
  return it == robots_.end() ? nullptr : &*it;
}

RobotWords* StatusBook::entry_of(const LayerId& layer) {
  const auto it =
      std::find_if(robots_.begin(), robots_.end(), [&](const RobotWords& w) { return w.layer.robot == layer.robot; });
  if (it == robots_.end()) {
    if (robots_.size() == robots_.capacity()) {
      ++counts_.left_out_robots;
      return nullptr;
    }
    robots_.emplace_back().layer = layer;
    return &robots_.back();
  }
  if (layer.incarnation < it->layer.incarnation) return nullptr;
  if (layer.incarnation > it->layer.incarnation) {
    *it = RobotWords{};
    it->layer = layer;
  }
  return &*it;
}

void StatusBook::update(const LayerStore& store, hal::TimeNs now_ns) {
  for (LayerIndex layer = 0; layer < store.layer_count(); ++layer) {
    if (store.id(layer).robot == self_) continue;
    RobotWords* const words = entry_of(store.id(layer));
    if (words == nullptr) continue;
    for (int kind = 0; kind < kStatusKinds; ++kind) {
      read(store, layer, static_cast<StatusKind>(kind), *words, now_ns);
    }
  }
}

void StatusBook::read(const LayerStore& store, LayerIndex layer, StatusKind kind, RobotWords& words,
                      hal::TimeNs now_ns) {
  const auto record = store.find_record(layer, status_key(kind));
  Version& version = words.versions[static_cast<std::size_t>(kind)];
  if (!record || record->version <= version || record->bytes > payload_.size()) return;
  version = record->version;
  const std::span<std::uint8_t> payload(payload_.data(), record->bytes);
  store.read(*record, payload);
  const StatusFault fault = take(kind, payload, words, now_ns);
  if (fault != StatusFault::none) {
    ++counts_.faults[static_cast<std::size_t>(fault)];
    return;
  }
  ++counts_.words;
  words.is_said[static_cast<std::size_t>(kind)] = true;
}

StatusFault StatusBook::take(StatusKind kind, mapper::ByteSpan payload, RobotWords& words, hal::TimeNs now_ns) {
  switch (kind) {
    case StatusKind::motion: {
      const StatusFault fault = read_status(payload, words.motion);
      if (fault == StatusFault::none) words.moved_ns = words.age.note(words.motion.said_ms, now_ns);
      return fault;
    }
    case StatusKind::offers:
      return read_status(payload, words.offers);
    case StatusKind::state:
      return read_status(payload, words.state);
    case StatusKind::contact:
      return read_status(payload, words.contact);
    case StatusKind::orders:
      return read_status(payload, words.orders);
  }
  return StatusFault::bad_number;
}

}  // namespace g3d::net
