// SPDX-License-Identifier: Apache-2.0
#include "net/block_tables.hpp"

#include <catch2/catch.hpp>

#include "mapper/files/bytes.hpp"
#include "net/trained_text.hpp"

using namespace g3d::net;

TEST_CASE("Digits and characters lead to each other, and no character needs an escape") {
  for (int digit = 0; digit <= kHighestDigit; ++digit) {
    const char c = char_of(digit);
    REQUIRE(digit_of(c) == digit);
    REQUIRE(c > '"');
    REQUIRE(c <= '~');
    REQUIRE(c != '?');
    REQUIRE(c != '\\');
  }
}

TEST_CASE("Groups follow each other, and the trained text has one character for each model and weight") {
  std::size_t next = 0;
  for (const ModelGroup& group : kModelGroups) {
    REQUIRE(group.begin == next);
    next = group.end();
  }
  CHECK(next == kModelCount);
  CHECK(kTrainedModels.size() == kModelCount);
  CHECK(kTrainedWeights.size() == kMixed * kMixCount);
}

TEST_CASE("Models start where the text says, and those of no context in the middle") {
  const StartModels models = read_models(std::string_view("Q~# X"));
  CHECK(models[0].probability == kEven - 16);  // squash(0) is 2047
  CHECK(models[1].probability > 65000);
  CHECK(models[2].probability < 500);
  CHECK(models[3].probability == kEven);
  CHECK(models[3].seen == 0);
  CHECK(models[0].seen == kSameGroup.trust);
  CHECK(models[kFlagGroup.begin].most == kFlagGroup.most);
}

TEST_CASE("The trained tables are those that the wire format is made of") {
  std::uint64_t sum = 0xCBF29CE484222325ULL;
  const auto add = [&](std::uint64_t value) { sum = (sum ^ value) * 0x100000001B3ULL; };
  for (const BitModel& model : trained_models()) add(model.probability | model.seen << 16 | model.most << 24);
  for (const MixWeights& set : trained_weights()) {
    for (const std::int32_t weight : set.of) add(static_cast<std::uint32_t>(weight));
  }
  CHECK(sum == 0x2D24BE98E4C81B7FULL);
}
