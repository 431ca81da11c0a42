// SPDX-License-Identifier: Apache-2.0
// How much one source may cost, and all strangers together. Asked before anything is decrypted: what is refused here
// costs a look into a table. A source that forges pays many times over and is soon refused unread. One thread; nothing
// allocates after construction.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hal/messages.hpp"
#include "net/token_bucket.hpp"

namespace g3d::net {

struct RateLimits {
  TokenRate per_source;
  TokenRate overall;         ///< of all that are not exempt
  double forged_cost = 0.0;  ///< tokens for each datagram that turned out to be forged, on top of its own
};

enum class RateVerdict : std::uint8_t { admitted, source_rate, overall_rate };

enum class RateClass : std::uint8_t {
  stranger,  ///< counts for `overall` as well
  known,     ///< is limited by itself alone: a flood of strangers takes nothing from it
};

/// What a source is called here; any number will do that is the same for the same source.
[[nodiscard]] constexpr std::uint64_t source_of(std::uint32_t ipv4, std::uint16_t port) {
  return std::uint64_t{ipv4} << 16 | port;
}

class RateLimit {
 public:
  /// Remembers about `most_sources`; of more, those that lose least by it are forgotten.
  RateLimit(const RateLimits& limits, std::size_t most_sources);

  [[nodiscard]] RateVerdict admit(std::uint64_t source, RateClass rate_class, hal::TimeNs now_ns);
  void charge_forged(std::uint64_t source, hal::TimeNs now_ns);

 private:
  static constexpr std::size_t kWays = 8;
  struct Entry {
    std::uint64_t source = 0;
    TokenBucket bucket;
  };
  using Set = std::array<Entry, kWays>;
  [[nodiscard]] TokenBucket& bucket_of(std::uint64_t source);

  const RateLimits limits_;
  const std::size_t mask_;
  std::array<std::uint8_t, 16> secret_;  ///< so that nobody can choose sources that fall into one set
  std::vector<Set> sets_;
  TokenBucket overall_;
};

}  // namespace g3d::net
