// SPDX-License-Identifier: Apache-2.0
// A radio between simulated robots that mistreats datagrams by a seed: range, loss, delay, overtaking, doubling, and
// links that are cut on a schedule. Who sends to everybody is heard by everybody in reach, each with its own luck.
// The same seed and calls give the same deliveries. One thread.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "hal/messages.hpp"
#include "hal/sim/seeded_random.hpp"
#include "mapper/files/bytes.hpp"

namespace g3d::net {

struct RadioModel {
  double loss = 0.0;     ///< share of datagrams that do not arrive
  double doubled = 0.0;  ///< share that arrives twice
  double late = 0.0;     ///< share that is overtaken: late_ns later
  hal::TimeNs delay_ns = 2'000'000;
  hal::TimeNs jitter_ns = 1'000'000;  ///< uniform, added to the delay
  hal::TimeNs late_ns = 60'000'000;
  std::uint64_t seed = 1;
};

class SimRadio {
 public:
  /// Station: 0 to `stations` - 1. `reaches`: whether two hear each other now; nothing: all do.
  using Reaches = std::function<bool(std::uint32_t from, std::uint32_t to, hal::TimeNs now_ns)>;
  static constexpr std::uint32_t kEveryStation = 0xFFFFFFFFU;

  SimRadio(std::uint32_t stations, const RadioModel& model, Reaches reaches = {})
      : stations_(stations), model_(model), reaches_(std::move(reaches)), random_(model.seed) {}

  void send(std::uint32_t from, std::uint32_t to, mapper::ByteSpan datagram, hal::TimeNs now_ns);
  /// Hands over what has arrived by now, in order of arrival. What is sent meanwhile may be among it.
  using Deliver = std::function<void(std::uint32_t from, std::uint32_t to, mapper::ByteSpan datagram)>;
  void deliver(hal::TimeNs now_ns, const Deliver& deliver);
  /// What is under way to a station is lost: it has been switched off.
  void forget(std::uint32_t to);

  void set_model(const RadioModel& model) { model_ = model; }
  [[nodiscard]] std::size_t under_way() const { return flights_.size(); }
  [[nodiscard]] std::uint64_t lost() const { return lost_; }
  [[nodiscard]] std::uint64_t delivered() const { return delivered_; }

 private:
  struct Flight {
    hal::TimeNs arrives_ns = 0;
    std::uint64_t number = 0;
    std::uint32_t from = 0;
    std::uint32_t to = 0;
    mapper::Bytes datagram;
    /// For a heap whose front arrives first.
    bool operator<(const Flight& other) const {
      return arrives_ns != other.arrives_ns ? arrives_ns > other.arrives_ns : number > other.number;
    }
  };
  void send_to(std::uint32_t from, std::uint32_t to, mapper::ByteSpan datagram, hal::TimeNs now_ns);

  std::uint32_t stations_;
  RadioModel model_;
  Reaches reaches_;
  hal::SeededRandom random_;
  std::vector<Flight> flights_;
  std::uint64_t next_number_ = 0;
  std::uint64_t lost_ = 0;
  std::uint64_t delivered_ = 0;
};

}  // namespace g3d::net
