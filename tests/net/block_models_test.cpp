// SPDX-License-Identifier: Apache-2.0
#include "net/block_models.hpp"

#include <catch2/catch.hpp>
#include <memory>
#include <set>

using namespace g3d::net;

TEST_CASE("After a restart models and weights are as trained") {
  const auto models = std::make_unique<BlockModels>();
  models->restart();
  const std::uint16_t before = models->same(0, 6, 0).probability;
  Mixed mixed = models->known(3, 5, 7, 2);
  const MixWeights weights = *mixed.weights;
  for (int i = 0; i < 50; ++i) {
    models->same(0, 6, 0).learn(false);
    (void)mixed.probability();
    mixed.learn(i % 3 == 0);
  }
  CHECK(models->same(0, 6, 0).probability != before);
  CHECK(mixed.weights->of != weights.of);
  models->restart();
  CHECK(models->same(0, 6, 0).probability == before);
  CHECK(models->known(3, 5, 7, 2).weights->of == weights.of);
}

TEST_CASE("Contexts have models of their own, to the last of each group") {
  const auto models = std::make_unique<BlockModels>();
  models->restart();
  std::set<const BitModel*> seen;
  std::size_t count = 0;
  const auto add = [&](const Mixed& mixed) {
    for (const BitModel* model : mixed.models) {
      seen.insert(model);
      ++count;
      REQUIRE(models->index_of(*model) < kModelCount);
    }
    REQUIRE(models->index_of(*mixed.weights) < kMixCount);
  };
  const auto add_one = [&](const BitModel& model) {
    seen.insert(&model);
    ++count;
    REQUIRE(models->index_of(model) < kModelCount);
  };
  for (std::size_t sort = 0; sort < 2; ++sort) {
    for (std::size_t node = 1; node <= 7; ++node) {
      for (std::size_t i = 0; i < 144; ++i) add(models->steps(sort, node, i, i, i));
    }
  }
  add(models->steps(1, 7, 164, 143, 359));
  count -= 1;  // 143 is known
  for (std::size_t channel = 0; channel < 3; ++channel) {
    for (std::size_t node = 0; node < kMixedNodes; ++node) {
      for (std::size_t i = 0; i < 16; ++i) add(models->colour(channel, {i, i, i}, node));
    }
    for (std::size_t width = 2; width <= 8; ++width) {
      for (std::size_t node = 1; node < 4; ++node) add_one(models->colour_top(channel, width, node));
    }
  }
  add(models->known(863, 1999, 431, 7));
  add(models->sort(431, 124, 728, 2));
  add_one(models->same(32, 6, 1));
  add_one(models->odd(1, 7, 7));
  add_one(models->has_colour(2));
  CHECK(seen.size() == count);
}
