// SPDX-License-Identifier: Apache-2.0
#include "net/rate_limit.hpp"

#include <sodium.h>

#include <bit>

namespace g3d::net {

RateLimit::RateLimit(const RateLimits& limits, std::size_t most_sources)
    : limits_(limits), mask_(std::bit_ceil((most_sources + kWays - 1) / kWays) - 1), sets_(mask_ + 1) {
  static_assert(sizeof(secret_) == crypto_shorthash_KEYBYTES);
  randombytes_buf(secret_.data(), secret_.size());
}

TokenBucket& RateLimit::bucket_of(std::uint64_t source) {
  std::uint64_t hash = 0;
  static_assert(sizeof(hash) == crypto_shorthash_BYTES);
  crypto_shorthash(reinterpret_cast<std::uint8_t*>(&hash), reinterpret_cast<const std::uint8_t*>(&source),
                   sizeof(source), secret_.data());
  Set& set = sets_[hash & mask_];
  // To forget a full bucket loses nothing, one in debt most.
  Entry* fullest = &set.front();
  for (Entry& entry : set) {
    if (entry.source == source) return entry.bucket;
    if (entry.bucket.full_at_ns() < fullest->bucket.full_at_ns()) fullest = &entry;
  }
  *fullest = Entry{source, {}};
  return fullest->bucket;
}

RateVerdict RateLimit::admit(std::uint64_t source, RateClass rate_class, hal::TimeNs now_ns) {
  TokenBucket& bucket = bucket_of(source);
  if (!bucket.holds_one(limits_.per_source, now_ns)) return RateVerdict::source_rate;
  if (rate_class == RateClass::stranger && !overall_.take(limits_.overall, now_ns)) return RateVerdict::overall_rate;
  (void)bucket.take(limits_.per_source, now_ns);
  return RateVerdict::admitted;
}

void RateLimit::charge_forged(std::uint64_t source, hal::TimeNs now_ns) {
  bucket_of(source).charge(limits_.per_source, limits_.forged_cost, now_ns);
}

}  // namespace g3d::net
