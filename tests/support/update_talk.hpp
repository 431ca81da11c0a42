// SPDX-License-Identifier: Apache-2.0
// An update in memory: both sides without sockets, and somebody between them who may cut the line or change bytes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "net/update_intake.hpp"
#include "net/update_offer.hpp"
#include "tests/support/slot_machine.hpp"

namespace g3d::test {

struct TalkOptions {
  bool force = false;
  double rate_Bps = 1e12;
  std::uint64_t cut_after_bytes = ~std::uint64_t{0};  ///< of the sender's
  /// Changes what the sender has sent, by its offset.
  std::function<void(std::uint64_t offset, std::vector<std::uint8_t>& bytes)> spoil;
};

struct TalkResult {
  std::optional<net::UpdateEnd> end;  ///< none: cut
  std::uint64_t sent_bytes = 0;
  std::uint32_t chunks = 0;  ///< that the machine asked for
  hal::TimeNs took_ns = 0;
  std::size_t most_held_bytes = 0;  ///< by the machine, for one message
  bool makes_sense = true;          ///< what the machine said
};

inline TalkResult talk(net::UpdateTarget& target, const net::UpdateKey& trusted, const net::SigningKey& key,
                       const net::UpdateManifest& manifest, const std::vector<std::uint8_t>& image,
                       const TalkOptions& options = {}) {
  static std::uint8_t counter = 0;
  std::array<std::uint8_t, 32> nonce{};
  nonce[0] = ++counter;
  net::UpdateIntake intake(trusted, target, nonce, options.rate_Bps);
  net::UpdateOffer offer(manifest, key, options.force);
  TalkResult result;
  std::vector<std::uint8_t> heard, flying;
  std::uint64_t flown_bytes = 0;
  bool is_greeted = false;
  hal::TimeNs now_ns = 0;
  const auto send = [&](std::vector<std::uint8_t> bytes) {
    if (options.spoil) options.spoil(flown_bytes + flying.size(), bytes);
    flying.insert(flying.end(), bytes.begin(), bytes.end());
  };
  for (;;) {
    const auto says = intake.says();
    heard.insert(heard.end(), says.begin(), says.end());
    intake.said(says.size());
    if (!is_greeted && heard.size() >= net::kGreeting_bytes) {
      net::GreetingBytes greeting;
      std::copy_n(heard.begin(), greeting.size(), greeting.begin());
      heard.erase(heard.begin(), heard.begin() + net::kGreeting_bytes);
      REQUIRE(offer.take_greeting(greeting));
      is_greeted = true;
      send(offer.opening());
    }
    while (heard.size() >= net::kWord_bytes) {
      net::WordBytes word;
      std::copy_n(heard.begin(), word.size(), word.begin());
      heard.erase(heard.begin(), heard.begin() + net::kWord_bytes);
      const auto next = offer.take_word(word);
      if (next == net::UpdateOffer::Next::nonsense) result.makes_sense = false;
      if (next == net::UpdateOffer::Next::ended) {
        result.end = offer.end();
        result.took_ns = now_ns;
        return result;
      }
      if (next != net::UpdateOffer::Next::send_chunk) continue;
      ++result.chunks;
      std::vector<std::uint8_t> bytes(net::kChunkHead_bytes);
      const std::uint32_t chunk = offer.chunk();
      std::memcpy(bytes.data(), &chunk, sizeof chunk);
      const auto at = image.begin() + static_cast<std::ptrdiff_t>(manifest.offset_of(chunk));
      bytes.insert(bytes.end(), at, at + static_cast<std::ptrdiff_t>(manifest.size_of(chunk)));
      send(std::move(bytes));
    }
    const bool worked = intake.step(now_ns);
    const auto wants = intake.wants();
    result.most_held_bytes = std::max(result.most_held_bytes, wants.size());
    const std::uint64_t left = options.cut_after_bytes - result.sent_bytes;
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>({wants.size(), flying.size(), left}));
    std::copy_n(flying.begin(), count, wants.begin());
    flying.erase(flying.begin(), flying.begin() + static_cast<std::ptrdiff_t>(count));
    result.sent_bytes += count;
    flown_bytes += count;
    intake.took(count);
    if (result.sent_bytes == options.cut_after_bytes) return result;
    if (worked || count > 0 || !intake.says().empty()) continue;
    REQUIRE(intake.wait_until_ns() < hal::TimeNs{1} << 60);  // else both would wait for ever
    now_ns = std::max(now_ns + 1, intake.wait_until_ns());
  }
}

}  // namespace g3d::test
