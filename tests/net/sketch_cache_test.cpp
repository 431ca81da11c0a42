// SPDX-License-Identifier: Apache-2.0
#include "net/sketch_cache.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/support/sample_maps.hpp"

using namespace g3d;

namespace {

/// What the cache is to give, by a pass of its own.
std::vector<net::SketchSymbol> made_anew(const net::LayerStore& store, net::LayerIndex layer,
                                         const net::SketchSalt& salt, std::uint32_t first, std::uint32_t count) {
  std::vector<net::SketchSymbol> symbols(count);
  net::SketchEncoder encoder(salt, first, symbols);
  store.for_each(
      layer, [&](const net::StoredRecord& record) { encoder.add(net::sketch_id(salt, record.key, record.version)); });
  return symbols;
}

}  // namespace

TEST_CASE("symbols from the cache are those of a pass of one's own, whatever was asked before", "[net][reconcile]") {
  net::LayerStore store({4, 1U << 12, std::size_t{1} << 18});
  const net::LayerIndex layers[] = {store.find_or_add({1, 1}), store.find_or_add({2, 1})};
  net::Version version = 0;
  const auto put = [&](net::LayerIndex layer) {
    ++version;
    (void)store.put(layer, net::block_record(0, version, net::Part::whole), version, net::Lane::rest, {});
  };
  for (int i = 0; i < 500; ++i) put(layers[i % 2]);
  net::SketchCache cache;
  tests::Random random{5};
  net::SketchSalt salts[] = {{1, 2}, {1, 3}};
  for (int i = 0; i < 400; ++i) {
    if (i % 10 == 0) put(layers[random.below(2)]);
    const net::LayerIndex layer = layers[random.below(2)];
    const net::SketchSalt& salt = salts[random.below(2)];
    const std::uint32_t first =
        i % 7 == 0 ? net::kMostSketchSymbols - 128 : static_cast<std::uint32_t>(random.below(300));
    const auto count = static_cast<std::uint32_t>(random.below(128) + 1);
    const auto given = cache.symbols(store, layer, salt, first, count);
    REQUIRE(std::ranges::equal(given, made_anew(store, layer, salt, first, count)));
  }
}

TEST_CASE("who asks for a few symbols at a time costs few passes", "[net][reconcile]") {
  net::LayerStore store({4, 1U << 12, std::size_t{1} << 18});
  const net::LayerIndex layer = store.find_or_add({1, 1});
  for (net::Version v = 1; v <= 100; ++v) {
    (void)store.put(layer, net::block_record(0, v, net::Part::whole), v, net::Lane::rest, {});
  }
  net::SketchCache cache;
  for (std::uint32_t first = 0; first < 1024; ++first) (void)cache.symbols(store, layer, {1, 2}, first, 1);
  CHECK(cache.passes() == 5);  // to 64, 128, 256, 512, 1024
}
