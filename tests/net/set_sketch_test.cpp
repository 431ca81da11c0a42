// SPDX-License-Identifier: Apache-2.0
#include "net/set_sketch.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdio>
#include <numeric>
#include <string>

#include "hal/sim/seeded_random.hpp"

using namespace g3d;
using namespace g3d::net;

namespace {

using SketchIds = std::vector<SketchId>;

SketchSalt sketch_salt(hal::SeededRandom& random) {
  const std::uint64_t low = random.bits();
  return {low, random.bits()};
}

SketchIds random_ids(hal::SeededRandom& random, std::size_t count) {
  SketchIds ids(count);
  std::ranges::generate(ids, [&] { return random.bits(); });
  return ids;
}

std::vector<SketchSymbol> symbols_of(const SketchSalt& salt, std::span<const SketchId> ids, std::uint32_t first,
                                     std::size_t count) {
  std::vector<SketchSymbol> symbols(count);
  SketchEncoder(salt, first, symbols).add(ids);
  return symbols;
}

SketchIds sorted(std::span<const SketchId> ids) {
  SketchIds copy(ids.begin(), ids.end());
  std::ranges::sort(copy);
  return copy;
}

/// Two sets and all symbols that a decoder for `most_differences` may ask for.
struct SketchPair {
  SketchPair(std::uint64_t seed, std::size_t only_ours, std::size_t only_peers, std::size_t common,
             std::uint32_t most_differences)
      : random(seed), salt(sketch_salt(random)), decoder(most_differences) {
    ours = random_ids(random, only_ours);
    peers = random_ids(random, only_peers);
    lacking_ours = sorted(ours);
    lacking_peers = sorted(peers);
    const SketchIds both = random_ids(random, common);
    ours.insert(ours.end(), both.begin(), both.end());
    peers.insert(peers.end(), both.begin(), both.end());
    encode(salt);
    decoder.start(salt);
  }
  void encode(const SketchSalt& peers_salt) {
    our_symbols = symbols_of(salt, ours, 0, decoder.most_symbols());
    peer_symbols = symbols_of(peers_salt, peers, 0, decoder.most_symbols());
  }
  SketchState give(std::uint32_t index, std::size_t count = 1) {
    return decoder.add(index, std::span(our_symbols).subspan(index, count),
                       std::span(peer_symbols).subspan(index, count));
  }
  SketchState give_in_order() {
    for (std::uint32_t i = 0; i < decoder.most_symbols(); ++i) {
      if (give(i) != SketchState::wants_symbols) break;
    }
    return decoder.state();
  }
  [[nodiscard]] bool is_right() const {
    return std::ranges::equal(decoder.only_ours(), lacking_ours) &&
           std::ranges::equal(decoder.only_peers(), lacking_peers);
  }

  hal::SeededRandom random;
  SketchSalt salt;
  SketchDecoder decoder;
  SketchIds ours, peers, lacking_ours, lacking_peers;
  std::vector<SketchSymbol> our_symbols, peer_symbols;
};

struct SketchCost {
  double mean = 0.0;   ///< symbols per difference
  double worst = 0.0;  ///< symbols per difference
  int failures = 0;
};
/// Over difference sets alone: what both have is subtracted to nothing, symbol by symbol, before the decoder sees it.
SketchCost cost_of(std::uint32_t differences, int trials, std::uint64_t seed) {
  hal::SeededRandom random(seed);
  SketchDecoder decoder(differences);
  // In steps that leave few symbols unused: a decoder takes them one by one.
  const std::uint32_t step = differences + 64;
  SketchCost cost;
  std::uint64_t sum = 0, worst = 0;
  for (int t = 0; t < trials; ++t) {
    const SketchSalt salt = sketch_salt(random);
    const SketchIds ids = random_ids(random, differences);
    const std::size_t ours = random.bits() % (differences + 1);
    decoder.start(salt);
    for (std::uint32_t first = 0; first < decoder.most_symbols(); first += step) {
      const auto a = symbols_of(salt, std::span(ids).first(ours), first, step);
      const auto b = symbols_of(salt, std::span(ids).subspan(ours), first, step);
      for (std::uint32_t i = 0; i < step && decoder.state() == SketchState::wants_symbols; ++i) {
        (void)decoder.add(first + i, std::span(a).subspan(i, 1), std::span(b).subspan(i, 1));
      }
      if (decoder.state() != SketchState::wants_symbols) break;
    }
    const bool is_right = std::ranges::equal(decoder.only_ours(), sorted(std::span(ids).first(ours))) &&
                          std::ranges::equal(decoder.only_peers(), sorted(std::span(ids).subspan(ours)));
    if (decoder.state() != SketchState::complete || !is_right) ++cost.failures;
    sum += decoder.taken_symbols();
    worst = std::max<std::uint64_t>(worst, decoder.taken_symbols());
  }
  cost.mean = static_cast<double>(sum) / trials / differences;
  cost.worst = static_cast<double>(worst) / differences;
  return cost;
}

}  // namespace

TEST_CASE("ids and symbols are the same on every machine", "[net][sketch]") {
  const SketchSalt salt{1, 2};
  SketchIds ids;
  for (std::uint64_t key = 0; key < 1000; ++key) ids.push_back(sketch_id(salt, key, key * key));
  CHECK(ids[3] == 0x497B41A900564DACULL);
  std::uint64_t digest = 0;
  for (const SketchSymbol& s : symbols_of(salt, ids, 0, 300)) {
    digest = sketch_mix(digest ^ s.id_xor) + s.check_xor + static_cast<std::uint32_t>(s.count);
  }
  CHECK(digest == 0xA58DB8633F71DCB7ULL);
  CHECK(sketch_id(salt, 3, 9) != sketch_id(salt, 3, 10));
  CHECK(sketch_id(salt, 3, 9) != sketch_id(salt, 9, 3));
  CHECK(sketch_id(salt, 3, 9) != sketch_id({2, 1}, 3, 9));
}

TEST_CASE("symbols made in parts are those made at once", "[net][sketch]") {
  hal::SeededRandom random(1);
  const SketchSalt salt = sketch_salt(random);
  const SketchIds ids = random_ids(random, 3000);
  const auto whole = symbols_of(salt, ids, 0, 1000);
  CHECK(whole[0].count == 3000);
  for (const auto& [first, count] : {std::pair{0U, 1U}, {0U, 64U}, {1U, 70U}, {63U, 2U}, {200U, 800U}, {999U, 1U}}) {
    CHECK(std::ranges::equal(symbols_of(salt, ids, first, count), std::span(whole).subspan(first, count)));
  }
}

TEST_CASE("equal sets are known by one symbol", "[net][sketch]") {
  const std::size_t items = GENERATE(0U, 1U, 1000U);
  SketchPair pair(items, 0, 0, items, GENERATE(0U, 100U));
  CHECK(pair.give(0) == SketchState::complete);
  CHECK(pair.is_right());
  CHECK(pair.decoder.taken_symbols() == 1);
}

TEST_CASE("one side has nothing", "[net][sketch]") {
  SketchPair poor(1, 0, 300, 0, 300), rich(2, 300, 0, 0, 300);
  CHECK(poor.give_in_order() == SketchState::complete);
  CHECK(poor.is_right());
  CHECK(rich.give_in_order() == SketchState::complete);
  CHECK(rich.is_right());
}

TEST_CASE("10^6 items of which 200 differ", "[net][sketch]") {
  hal::SeededRandom random(11);
  const SketchSalt salt = sketch_salt(random);
  SketchIds ours(1'000'100);
  for (std::uint64_t n = 0; n < ours.size(); ++n) ours[n] = sketch_id(salt, n, n % 7);
  SketchIds peers(ours.begin() + 100, ours.end());
  for (std::size_t n = 0; n < 50; ++n) peers[n * 1000] = sketch_id(salt, n * 1000 + 100, 8);
  SketchDecoder decoder(1000);
  decoder.start(salt);
  auto a = symbols_of(salt, ours, 0, 128);
  CHECK(decoder.add(0, a, symbols_of(salt, peers, 0, 128)) == SketchState::wants_symbols);
  a = symbols_of(salt, ours, 128, 272);
  CHECK(decoder.add(128, a, symbols_of(salt, peers, 128, 272)) == SketchState::complete);
  CHECK(decoder.only_ours().size() == 150);
  CHECK(decoder.only_peers().size() == 50);
  SketchIds more;
  std::ranges::sort(ours);
  std::ranges::sort(peers);
  std::ranges::set_difference(ours, peers, std::back_inserter(more));
  CHECK(std::ranges::equal(decoder.only_ours(), more));
  more.clear();
  std::ranges::set_difference(peers, ours, std::back_inserter(more));
  CHECK(std::ranges::equal(decoder.only_peers(), more));
}

TEST_CASE("few differences take at most 1.8 symbols each, many at most 1.45", "[net][sketch]") {
  for (std::uint32_t d = 1; d < 64; ++d) {
    const SketchCost cost = cost_of(d, d < 16 ? 8000 / static_cast<int>(d) : 200, d);
    INFO(d << " differences: " << cost.mean);
    CHECK(cost.mean <= 1.8);
    CHECK(cost.failures == 0);
  }
  for (const std::uint32_t d : {256U, 500U, 1000U, 4096U}) {
    const SketchCost cost = cost_of(d, 10000 / static_cast<int>(d), d);
    INFO(d << " differences: " << cost.mean);
    CHECK(cost.mean <= 1.45);
    CHECK(cost.failures == 0);
  }
}

TEST_CASE("the time that 10^6 items take", "[net][sketch][.soak]") {
  hal::SeededRandom random(1);
  const SketchIds ids = random_ids(random, 1'000'000);
  for (const auto& [first, count] : {std::pair{0U, 128U}, {128U, 128U}, {256U, 256U}, {512U, 512U}, {1024U, 7168U}}) {
    const auto started = std::chrono::steady_clock::now();
    CHECK(symbols_of({}, ids, first, count).size() == count);
    const std::chrono::duration<double> took_s = std::chrono::steady_clock::now() - started;
    std::printf("symbols %u .. %u: %.3f s\n", first, first + count - 1, took_s.count());
    CHECK(took_s.count() < 0.5);
  }
}

TEST_CASE("what differences cost, over many trials", "[net][sketch][.soak]") {
  std::vector<std::uint32_t> counts(63);
  std::iota(counts.begin(), counts.end(), 1U);
  for (std::uint32_t d = 64; d <= 4096; d *= 2) counts.push_back(d);
  int failures = 0;
  for (const std::uint32_t d : counts) {
    const SketchCost cost = cost_of(d, std::max(400, 2'000'000 / static_cast<int>(d)), d + 1000);
    std::printf("%4u differences: %.3f symbols each, %.2f at worst\n", d, cost.mean, cost.worst);
    CHECK(cost.mean <= (d < 256 ? 1.8 : 1.45));
    failures += cost.failures;
  }
  // Each of 10^7 trials has a chance below 2 of 10^6 to be refused.
  CHECK(failures <= 30);
}

TEST_CASE("symbols come in any order, twice or never", "[net][sketch]") {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const std::size_t ours = seed % 40, peers = seed * 7 % 50;
    SketchPair pair(seed, ours, peers, 100, 90);
    // One of four never comes, symbol 0 excepted.
    std::vector<std::uint32_t> order;
    for (std::uint32_t i = 0; i < pair.decoder.most_symbols(); ++i) {
      if (i == 0 || pair.random.bits() % 4 != 0) order.push_back(i);
    }
    for (std::size_t i = 0; i + 1 < order.size(); ++i) {
      // Far ones seldom: they say little.
      std::swap(order[i], order[i + pair.random.bits() % std::min<std::size_t>(order.size() - i, 40)]);
    }
    std::uint32_t given = 0;
    for (const std::uint32_t index : order) {
      (void)pair.give(index);
      ++given;
      if (pair.decoder.state() != SketchState::wants_symbols) break;
      REQUIRE(pair.decoder.has_symbol(index));
      (void)pair.give(index);
      REQUIRE(pair.decoder.taken_symbols() == given);
      REQUIRE(pair.decoder.only_ours().empty());
      REQUIRE(pair.decoder.only_peers().empty());
    }
    INFO("seed " << seed);
    CHECK(pair.decoder.state() == SketchState::complete);
    CHECK(pair.is_right());
  }
}

TEST_CASE("without symbol 0 nothing is complete, however late it comes", "[net][sketch]") {
  SketchPair pair(3, 5, 6, 100, 50);
  CHECK(pair.give(1, 200) == SketchState::wants_symbols);
  CHECK(pair.decoder.only_ours().empty());
  CHECK_FALSE(pair.decoder.has_symbol(0));
  CHECK(pair.give(0) == SketchState::complete);
  CHECK(pair.is_right());
  CHECK(pair.give(201) == SketchState::complete);
}

TEST_CASE("symbols of another salt are refused", "[net][sketch]") {
  for (std::uint64_t seed = 1; seed < 100; ++seed) {
    const std::size_t items = seed % 10;
    SketchPair pair(seed, items, items, 1, 100);
    pair.encode(SketchSalt{pair.salt.low + seed % 2, pair.salt.high + (1 - seed % 2)});
    REQUIRE(pair.give_in_order() == SketchState::too_many_differences);
    REQUIRE(pair.decoder.taken_symbols() == pair.decoder.most_symbols());
    REQUIRE(pair.decoder.only_ours().empty());
    REQUIRE(pair.decoder.only_peers().empty());
  }
}

TEST_CASE("a decoder takes as many differences as it was made for", "[net][sketch]") {
  const std::uint32_t most = GENERATE(0U, 1U, 10U, 300U);
  SketchPair fits(most, most / 2, most - most / 2, 50, most), does_not(most, most / 2, most - most / 2 + 1, 50, most);
  CHECK(fits.give_in_order() == SketchState::complete);
  CHECK(fits.is_right());
  CHECK(does_not.give_in_order() == SketchState::too_many_differences);
  CHECK(does_not.decoder.only_peers().empty());
}

TEST_CASE("sets of too different sizes are refused at their first symbol", "[net][sketch]") {
  SketchPair pair(1, 0, 101, 50, 100), other(1, 101, 0, 50, 100);
  CHECK(pair.give(0) == SketchState::too_many_differences);
  CHECK(other.give(0) == SketchState::too_many_differences);
}

TEST_CASE("symbols past a decoder's end are left out", "[net][sketch]") {
  SketchPair pair(1, 3, 3, 50, 10);
  const std::uint32_t end = pair.decoder.most_symbols();
  const std::vector<SketchSymbol> strange(10, SketchSymbol{1, 2, 3});
  CHECK(pair.decoder.add(end, strange, strange) == SketchState::wants_symbols);
  CHECK(pair.decoder.add(0xFFFFFFFFU, strange, strange) == SketchState::wants_symbols);
  CHECK(pair.decoder.taken_symbols() == 0);
  CHECK(pair.give_in_order() == SketchState::complete);
  CHECK(pair.is_right());
}

TEST_CASE("symbols that are of no one set give no answer", "[net][sketch]") {
  enum class Wrong { item_twice, item_came_meanwhile, count_changed, noise };
  const Wrong wrong = GENERATE(Wrong::item_twice, Wrong::item_came_meanwhile, Wrong::count_changed, Wrong::noise);
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    SketchPair pair(seed, 4, 5, 50, 30);
    switch (wrong) {
      case Wrong::item_twice:
        pair.peers.push_back(pair.peers.front());
        pair.encode(pair.salt);
        break;
      case Wrong::item_came_meanwhile: {
        const SketchSymbol old = pair.peer_symbols[0];
        pair.peers.push_back(pair.random.bits());
        pair.encode(pair.salt);
        pair.peer_symbols[0] = old;
        break;
      }
      case Wrong::count_changed:
        ++pair.peer_symbols[seed % 3].count;
        break;
      case Wrong::noise:
        for (SketchSymbol& s : pair.peer_symbols) {
          s = {pair.random.bits(), static_cast<std::uint32_t>(pair.random.bits()), static_cast<std::int32_t>(seed)};
        }
        break;
    }
    // All at once: a part of them may be of one set.
    const SketchState state = pair.give(0, pair.decoder.most_symbols());
    INFO("seed " << seed << ", " << to_string(state));
    CHECK((state == SketchState::too_many_differences || state == SketchState::contradictory));
    CHECK(pair.decoder.only_ours().empty());
    CHECK(pair.decoder.only_peers().empty());
  }
}

TEST_CASE("a decoder that starts again forgets all", "[net][sketch]") {
  SketchPair first(1, 10, 10, 50, 20), second(2, 7, 9, 50, 20);
  CHECK(first.give(0, 5) == SketchState::wants_symbols);
  first.decoder.start(second.salt);
  CHECK(first.decoder.add(0, second.our_symbols, second.peer_symbols) == SketchState::complete);
  CHECK(std::ranges::equal(first.decoder.only_peers(), second.lacking_peers));
  CHECK(std::ranges::equal(first.decoder.only_ours(), second.lacking_ours));
}

TEST_CASE("every state of a decoder has a name", "[net][sketch]") {
  for (int i = 0; i <= static_cast<int>(SketchState::contradictory); ++i) {
    CHECK(std::string(to_string(static_cast<SketchState>(i))) != "?");
  }
  CHECK(std::string(to_string(static_cast<SketchState>(99))) == "?");
}
