// SPDX-License-Identifier: Apache-2.0
// Datagrams as somebody sends them who has no key but a radio, all recordings, and a grudge: noise, forgeries in the
// name of a robot, recordings, recordings with another end or other bits, pieces of two, and what another fleet says.
// The same seed and recordings give the same. Plain.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "hal/sim/seeded_random.hpp"
#include "net/datagram_seal.hpp"
#include "tests/support/memory_air.hpp"

namespace g3d::test {

enum class Hostile : std::uint8_t { noise, forged, recorded, truncated, flipped, spliced, foreign, count_ };
inline constexpr std::size_t kHostileKinds = static_cast<std::size_t>(Hostile::count_);

class HostileSender {
 public:
  using Recordings = std::vector<std::pair<net::Address, mapper::Bytes>>;
  /// `heard`: what the fleet has said, and goes on saying; `foreign`: what another fleet has. Both outlive this, and
  /// `heard` is not empty.
  HostileSender(const Recordings& heard, const Recordings& foreign, std::uint64_t seed)
      : heard_(heard), foreign_(foreign), random_(seed) {}

  /// The next one, and where it seems to come from: a robot, always the same stranger, or anywhere.
  std::pair<net::Address, mapper::Bytes> next() {
    const auto kind = static_cast<Hostile>(random_.bits() % kHostileKinds);
    ++counts[static_cast<std::size_t>(kind)];
    const auto& [from, recorded] = one_of(heard_);
    net::Address source = from;
    switch (random_.bits() % 3) {
      case 0:
        source = 666;
        break;
      case 1:
        source = random_.bits() | 1;
        break;
      default:
        break;
    }
    return {source, made(kind, recorded)};
  }

  std::array<std::uint64_t, kHostileKinds> counts{};  ///< by Hostile

 private:
  [[nodiscard]] const std::pair<net::Address, mapper::Bytes>& one_of(const Recordings& recordings) {
    return recordings[random_.bits() % recordings.size()];
  }
  void fill(mapper::Bytes& bytes, std::size_t from) {
    for (std::size_t i = from; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(random_.bits());
  }
  mapper::Bytes made(Hostile kind, mapper::Bytes bytes) {
    switch (kind) {
      case Hostile::noise:
        bytes.resize(random_.bits() % 1400);
        fill(bytes, 0);
        break;
      case Hostile::forged: {
        // A robot's session and a counter that it may have come to.
        const std::size_t known_bytes = net::kEnvelopeHeader_bytes - (random_.bits() % 2 == 0 ? 0 : 4);
        bytes.resize(net::kEnvelope_bytes + random_.bits() % (net::kMostPlaintext_bytes + 1));
        fill(bytes, known_bytes);
        break;
      }
      case Hostile::truncated:
        bytes.resize(random_.bits() % bytes.size());
        break;
      case Hostile::flipped:
        for (std::uint64_t bits = 1 + random_.bits() % 3; bits > 0; --bits) {
          const std::uint64_t bit = random_.bits() % (8 * bytes.size());
          bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ 1U << bit % 8);
        }
        break;
      case Hostile::spliced: {
        const mapper::Bytes& other = one_of(heard_).second;
        for (std::size_t i = 0; i < std::min(net::kEnvelopeHeader_bytes, other.size()); ++i) bytes[i] = other[i];
        break;
      }
      case Hostile::foreign:
        return one_of(foreign_).second;
      case Hostile::recorded:
      case Hostile::count_:
        break;
    }
    return bytes;
  }

  const Recordings& heard_;
  const Recordings& foreign_;
  hal::SeededRandom random_;
};

}  // namespace g3d::test
