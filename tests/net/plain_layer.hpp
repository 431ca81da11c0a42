// SPDX-License-Identifier: Apache-2.0
// A layer of a store as a std::map, for tests to compare with.
#pragma once

#include <algorithm>
#include <map>

#include "net/layer_store.hpp"

namespace g3d::tests {

struct PlainStored {
  net::Version version = 0;
  net::Lane lane = net::Lane::rest;
  mapper::Bytes payload;
};

constexpr std::size_t chunks_of(std::size_t bytes) { return (bytes + 27) / 28; }

/// A layer as a std::map, and what the rule about whole blocks and halves says of it.
class PlainLayer {
 public:
  [[nodiscard]] net::Version version_of(net::RecordKey key) const {
    const auto it = records_.find(key);
    return it == records_.end() ? 0 : it->second.version;
  }
  [[nodiscard]] bool has(net::RecordKey key) const { return records_.contains(key); }
  [[nodiscard]] const std::map<net::RecordKey, PlainStored>& records() const { return records_; }

  [[nodiscard]] bool is_superseded(net::RecordKey key, net::Version version) const {
    if (version_of(key) >= version) return true;
    if (net::kind_of(key) != net::RecordKind::block) return false;
    if (net::part_of(key) != net::Part::whole) return version_of(net::with_part(key, net::Part::whole)) > version;
    return version_of(net::with_part(key, net::Part::low_half)) > version &&
           version_of(net::with_part(key, net::Part::high_half)) > version;
  }
  [[nodiscard]] bool is_taken(net::Lane lane, net::Version version) const {
    return std::any_of(records_.begin(), records_.end(),
                       [&](const auto& entry) { return entry.second.lane == lane && entry.second.version == version; });
  }
  void put(net::RecordKey key, const PlainStored& record) {
    records_[key] = record;
    if (net::kind_of(key) != net::RecordKind::block) return;
    std::erase_if(records_, [&](const auto& entry) {
      const net::RecordKey whole = net::with_part(key, net::Part::whole);
      return net::kind_of(entry.first) == net::RecordKind::block &&
             net::with_part(entry.first, net::Part::whole) == whole && is_covered(entry.first, entry.second.version);
    });
  }
  /// What stands in a lane, by version.
  [[nodiscard]] std::map<net::Version, net::RecordKey> lane(net::Lane of) const {
    std::map<net::Version, net::RecordKey> by_version;
    for (const auto& [key, record] : records_) {
      if (record.lane == of) by_version[record.version] = key;
    }
    return by_version;
  }
  [[nodiscard]] std::size_t payload_bytes() const {
    std::size_t sum = 0;
    for (const auto& [key, record] : records_) sum += record.payload.size();
    return sum;
  }
  [[nodiscard]] std::size_t chunks() const {
    std::size_t sum = 0;
    for (const auto& [key, record] : records_) sum += chunks_of(record.payload.size());
    return sum;
  }

 private:
  /// By other records of its block: all of its voxels are newer elsewhere.
  [[nodiscard]] bool is_covered(net::RecordKey key, net::Version version) const {
    if (net::part_of(key) != net::Part::whole) return version_of(net::with_part(key, net::Part::whole)) > version;
    return version_of(net::with_part(key, net::Part::low_half)) > version &&
           version_of(net::with_part(key, net::Part::high_half)) > version;
  }
  std::map<net::RecordKey, PlainStored> records_;
};

}  // namespace g3d::tests
