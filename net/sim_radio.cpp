// SPDX-License-Identifier: Apache-2.0
#include "net/sim_radio.hpp"

#include <algorithm>
#include <utility>

namespace g3d::net {

void SimRadio::send(std::uint32_t from, std::uint32_t to, mapper::ByteSpan datagram, hal::TimeNs now_ns) {
  if (to != kEveryStation) return send_to(from, to, datagram, now_ns);
  for (std::uint32_t station = 0; station < stations_; ++station) {
    if (station != from) send_to(from, station, datagram, now_ns);
  }
}

void SimRadio::send_to(std::uint32_t from, std::uint32_t to, mapper::ByteSpan datagram, hal::TimeNs now_ns) {
  if (reaches_ && !reaches_(from, to, now_ns)) {
    ++lost_;
    return;
  }
  if (random_.happens(model_.loss)) {
    ++lost_;
    return;
  }
  const int copies = random_.happens(model_.doubled) ? 2 : 1;
  for (int i = 0; i < copies; ++i) {
    hal::TimeNs delay = model_.delay_ns;
    if (model_.jitter_ns > 0)
      delay += static_cast<hal::TimeNs>(random_.uniform() * static_cast<double>(model_.jitter_ns));
    if (random_.happens(model_.late)) delay += model_.late_ns;
    flights_.push_back({now_ns + delay, next_number_++, from, to, {datagram.begin(), datagram.end()}});
    std::push_heap(flights_.begin(), flights_.end());
  }
}

void SimRadio::deliver(hal::TimeNs now_ns, const Deliver& deliver) {
  while (!flights_.empty() && flights_.front().arrives_ns <= now_ns) {
    std::pop_heap(flights_.begin(), flights_.end());
    const Flight flight = std::move(flights_.back());
    flights_.pop_back();
    ++delivered_;
    deliver(flight.from, flight.to, flight.datagram);
  }
}

void SimRadio::forget(std::uint32_t to) {
  const auto end = std::remove_if(flights_.begin(), flights_.end(), [&](const Flight& f) { return f.to == to; });
  lost_ += static_cast<std::uint64_t>(flights_.end() - end);
  flights_.erase(end, flights_.end());
  std::make_heap(flights_.begin(), flights_.end());
}

}  // namespace g3d::net
