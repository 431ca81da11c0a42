// SPDX-License-Identifier: Apache-2.0
#include "net/block_tables.hpp"

#include <algorithm>

#include "net/trained_text.hpp"

namespace g3d::net {

StartModels read_models(std::string_view text) {
  StartModels models{};
  for (const ModelGroup& group : kModelGroups) {
    for (std::size_t i = group.begin; i < group.end(); ++i) {
      BitModel& model = models[i];
      model.most = group.most;
      if (i >= text.size() || text[i] == ' ') continue;
      const int logit = (digit_of(text[i]) - kMiddleDigit) * 64;
      model.probability = static_cast<std::uint16_t>(squash(std::clamp(logit, -kMaxLogit, kMaxLogit)) << 4);
      model.seen = group.trust;
    }
  }
  return models;
}

StartWeights read_weights(std::string_view text) {
  StartWeights weights{};
  for (std::size_t i = 0; i < kMixed * weights.size() && i < text.size(); ++i) {
    weights[i / kMixed].of[i % kMixed] = (digit_of(text[i]) - kMiddleDigit) * (65536 / 32);
  }
  return weights;
}

const StartModels& trained_models() {
  static const StartModels models = read_models(kTrainedModels);
  return models;
}

const StartWeights& trained_weights() {
  static const StartWeights weights = read_weights(kTrainedWeights);
  return weights;
}

}  // namespace g3d::net
