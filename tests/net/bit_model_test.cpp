// SPDX-License-Identifier: Apache-2.0
#include "net/bit_model.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::net;

TEST_CASE("Probabilities rise with logits, stay inside, and are those of the logistic function") {
  for (int logit = -kMaxLogit; logit <= kMaxLogit; ++logit) {
    const int p = squash(logit);
    REQUIRE(p >= 1);
    REQUIRE(p <= 4095);
    if (logit > -kMaxLogit) REQUIRE(p >= squash(logit - 1));
    REQUIRE(std::abs(p - 4096.0 / (1.0 + std::exp(-logit / 256.0))) < 16.0);
  }
}

TEST_CASE("A logit and its probability lead to each other") {
  for (int p = 1; p < 4096; ++p) REQUIRE(std::abs(squash(kStretch[static_cast<std::size_t>(p)]) - p) <= 4);
}

TEST_CASE("A model goes where the bits are and is never certain", "[long]") {
  for (const bool bit : {false, true}) {
    BitModel model;
    for (int i = 0; i < 100'000; ++i) {
      model.learn(bit);
      REQUIRE(model.probability >= 16);
      REQUIRE(model.probability <= 65519);
    }
    CHECK((bit ? model.probability > 65000 : model.probability < 500));
  }
  BitModel model;
  tests::Random random(4);
  for (int i = 0; i < 2000; ++i) model.learn(random.below(4) == 0);
  CHECK(std::abs(model.probability - 16384) < 2500);
}

TEST_CASE("A mix comes to trust the model that knows") {
  tests::Random random(5);
  std::array<BitModel, 4> models;
  MixWeights weights;
  weights.of.fill(20000);
  for (int i = 0; i < 512; ++i) {
    const bool bit = random.below(2) == 0;
    Mixed mixed{{&models[bit ? 0 : 1], &models[2], &models[3]}, &weights};
    REQUIRE(mixed.probability() > 0);
    REQUIRE(mixed.probability() < 65536);
    mixed.learn(bit);
  }
  CHECK(weights.of[0] > 2 * weights.of[1]);
}
