// SPDX-License-Identifier: Apache-2.0
#include "tests/support/datagram_relay.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace g3d::test {
namespace {

constexpr std::uint32_t kLoopback_ipv4 = 0x7F000001;

}  // namespace

DatagramRelay::DatagramRelay(std::uint32_t robots, const RelayModel& model, std::vector<RelayCut> cuts)
    : robots_(robots),
      model_(model),
      cuts_(std::move(cuts)),
      radio_(robots, model.radio,
             [this](std::uint32_t from, std::uint32_t to, hal::TimeNs now_ns) {
               return std::none_of(cuts_.begin(), cuts_.end(), [&](const RelayCut& cut) {
                 return std::minmax(cut.a, cut.b) == std::minmax(from, to) && now_ns >= cut.from_ns &&
                        now_ns < cut.until_ns;
               });
             }),
      random_(model.radio.seed * 31 + 7),
      where_(robots) {
  hal::UdpSocketOptions options;
  options.bind.ipv4 = kLoopback_ipv4;
  for (std::uint32_t i = 0; i < robots * robots; ++i) {
    auto socket = hal::UdpSocket::open(options);
    if (!socket) throw std::runtime_error(socket.error().text);
    doors_.push_back(std::move(socket).value());
  }
}

std::vector<std::string> DatagramRelay::peers_of(std::uint32_t i) const {
  std::vector<std::string> peers;
  for (std::uint32_t other = 0; other < robots_; ++other) {
    if (other != i) peers.push_back(hal::to_string(door(i, other).bound()));
  }
  return peers;
}

void DatagramRelay::set_model(const RelayModel& model) {
  model_ = model;
  radio_.set_model(model.radio);
}

void DatagramRelay::pump(hal::TimeNs now_ns) {
  for (std::uint32_t from = 0; from < robots_; ++from) {
    for (std::uint32_t to = 0; to < robots_; ++to) {
      while (const auto received = door(from, to).receive()) {
        where_[from] = received->from;
        take(from, to, received->datagram, now_ns);
      }
    }
  }
  radio_.deliver(now_ns, [this](std::uint32_t from, std::uint32_t to, mapper::ByteSpan datagram) {
    hand_over(from, to, datagram);
  });
}

void DatagramRelay::take(std::uint32_t from, std::uint32_t to, mapper::ByteSpan datagram, hal::TimeNs now_ns) {
  mapper::Bytes bytes(datagram.begin(), datagram.end());
  capture_.push_back({from, to, bytes});
  if (random_.happens(model_.flipped) && !bytes.empty()) {
    const std::uint64_t bit = random_.bits() % (8 * bytes.size());
    bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ 1U << bit % 8);
    ++counts_.flipped;
  }
  if (random_.happens(model_.truncated) && !bytes.empty()) {
    bytes.resize(random_.bits() % bytes.size());
    ++counts_.truncated;
  }
  radio_.send(from, to, bytes, now_ns);
}

void DatagramRelay::hand_over(std::uint32_t from, std::uint32_t to, mapper::ByteSpan datagram) {
  if (where_[to].port == 0) {
    ++counts_.nowhere;
    return;
  }
  (void)door(to, from).send(where_[to], datagram);
}

}  // namespace g3d::test
