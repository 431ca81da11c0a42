// SPDX-License-Identifier: Apache-2.0
// Trains the tables of net/trained_text.hpp and prints them: counts in every context which bits came, over blocks that
// changed while our own simulated maps grew, and finds the weights of the mixes by following their gradient.
//   block_train_bench [EARLIER.g3d LATER.g3d]...
// Two flights are always taken (furnished_room at 5 cm, office at 2 cm), and of each pair of maps the blocks that
// differ: runs of `g3dmap sim --robots 1` of d and d + 1 seconds. trained_text.hpp says which ones made its table.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "net/block_colours.hpp"
#include "net/block_levels.hpp"
#include "tests/support/changed_blocks.hpp"

using namespace g3d;

namespace {

using Sets = std::vector<std::vector<mapper::BlockValues>>;

struct Trained {
  net::StartModels models{};
  net::StartWeights weights{};
};

/// Looks like an encoder to the codings, and writes nothing.
class CountingCoder {
 public:
  CountingCoder(net::BlockModels& models, Trained& trained, bool with_weights)
      : models_(models), trained_(trained), exact_(net::kMixCount), with_weights_(with_weights) {
    for (std::size_t i = 0; i < net::kMixCount; ++i) {
      for (std::size_t k = 0; k < net::kMixed; ++k) exact_[i][k] = trained.weights[i].of[k];
    }
  }
  bool code(net::BitModel& model, bool bit) {
    count(model, bit);
    model.learn(bit);
    return bit;
  }
  bool code(net::Mixed mixed, bool bit) {
    const double missed = (bit ? 1.0 : 0.0) - mixed.probability() / 65536.0;
    const std::size_t set = models_.index_of(*mixed.weights);
    for (std::size_t k = 0; k < net::kMixed; ++k) {
      count(*mixed.models[k], bit);
      exact_[set][k] += 65536.0 * 0.0002 * missed * mixed.logits[k] / 256.0;
      if (with_weights_) trained_.weights[set].of[k] = static_cast<std::int32_t>(std::lround(exact_[set][k]));
    }
    mixed.learn(bit);
    return bit;
  }
  static std::uint32_t code_plain(std::uint32_t bits, int /*unused*/) { return bits; }

  [[nodiscard]] std::string model_text() const {
    std::string text;
    for (const auto& [zeros, ones] : counts_) {
      const double logit = std::log((ones + 0.4) / (zeros + 0.4));
      const auto digit = static_cast<int>(std::lround(4 * logit)) + net::kMiddleDigit;
      text += zeros + ones == 0 ? ' ' : net::char_of(std::clamp(digit, 0, net::kHighestDigit));
    }
    return text;
  }

 private:
  void count(const net::BitModel& model, bool bit) {
    auto& [zeros, ones] = counts_[models_.index_of(model)];
    (bit ? ones : zeros) += 1;
  }
  net::BlockModels& models_;
  Trained& trained_;
  std::vector<std::array<double, 2>> counts_{net::kModelCount};
  std::vector<std::array<double, net::kMixed>> exact_;
  bool with_weights_;
};

bool is_uniform(const mapper::BlockValues& values) {
  return std::all_of(values.begin(), values.end(), [&](mapper::Rgbo value) { return value == values[0]; });
}

std::string train_once(const Sets& sets, Trained& trained, bool with_weights) {
  const auto models = std::make_unique<net::BlockModels>(trained.models, trained.weights);
  const auto tints = std::make_unique<net::TintGrid>();
  CountingCoder coder(*models, trained, with_weights);
  std::size_t most = 0;
  for (const auto& set : sets) most = std::max(most, set.size());
  for (std::size_t i = 0; i < most; ++i) {
    for (const auto& set : sets) {
      if (i >= set.size() || is_uniform(set[i])) continue;
      mapper::BlockValues values = set[i];
      net::LevelGrid levels;
      levels.fill(net::kNoLevel);
      for (std::size_t at = 0; at < values.size(); ++at) {
        levels[net::kGridOrder.grid[at]] = mapper::level_of(values[net::kGridOrder.block[at]]);
      }
      models->restart();
      net::LevelCoding(coder, *models).run(levels, net::places_of(net::Part::whole));
      net::ColourCoding(coder, *models).run(values, *tints, net::places_of(net::Part::whole));
    }
  }
  return coder.model_text();
}

std::string weight_text(const net::StartWeights& weights) {
  std::string text;
  for (const net::MixWeights& set : weights) {
    for (const std::int32_t weight : set.of) {
      const auto digit = static_cast<int>(std::lround(weight / 2048.0)) + net::kMiddleDigit;
      text += net::char_of(std::clamp(digit, 0, net::kHighestDigit));
    }
  }
  return text;
}

void print(const char* name, const std::string& text) {
  constexpr std::size_t kColumns = 112;
  fmt::print("inline constexpr std::string_view {} =\n", name);
  for (std::size_t at = 0; at < text.size(); at += kColumns) {
    fmt::print("    \"{}\"{}\n", text.substr(at, kColumns), at + kColumns < text.size() ? "" : ";");
  }
}

}  // namespace

int main(int argc, char** argv) {
  Sets sets;
  sets.push_back(test::changed_blocks(test::simulated_drive("furnished_room", 240, 0.1, 0.0, 320), 0.05F, 10, 200));
  sets.push_back(test::changed_blocks(test::simulated_drive("office", 120, 0.1, 0.0, 320), 0.02F, 10, 400));
  sets.emplace_back();
  for (int i = 1; i + 1 < argc; i += 2) {
    const auto blocks = test::changed_blocks(argv[i], argv[i + 1]);
    sets.back().insert(sets.back().end(), blocks.begin(), blocks.end());
  }
  for (const auto& set : sets) fmt::print(stderr, "{} blocks\n", set.size());
  const auto trained = std::make_unique<Trained>();
  for (net::MixWeights& set : trained->weights) set.of.fill(20000);
  std::string text = train_once(sets, *trained, false);
  for (int round = 0; round < 4; ++round) {
    trained->models = net::read_models(text);
    text = train_once(sets, *trained, true);
  }
  print("kTrainedModels", text);
  print("kTrainedWeights", weight_text(trained->weights));
  return 0;
}
