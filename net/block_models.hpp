// SPDX-License-Identifier: Apache-2.0
// All that the coding of a block expects, in one array. Every block and every half starts from the trained table,
// because the datagram before may be lost. A model is set back when a block first asks for it: few of them are.
#pragma once

#include "net/block_tables.hpp"

namespace g3d::net {

class BlockModels {
 public:
  /// Both must outlive this.
  explicit BlockModels(const StartModels& models = trained_models(), const StartWeights& weights = trained_weights())
      : start_models_(models), start_weights_(weights), weights_(weights) {}

  /// Forgets what the last block taught.
  void restart() {
    if (++epoch_ == 0) {
      for (BitModel& model : models_) model.epoch = 0;
      epoch_ = 1;
    }
    weights_ = start_weights_;
  }

  BitModel& same(std::size_t level, std::size_t like, std::size_t lone) {
    return at(kSameGroup, (level * 7 + like) * 2 + lone);
  }
  /// Of a voxel among known ones: so sure that one model will do.
  BitModel& known_inside(std::size_t strength) { return at(kKnownStrength, strength); }
  Mixed known(std::size_t faces, std::size_t strength, std::size_t corners, std::size_t mix) {
    return {{&at(kKnownFaces, faces), &at(kKnownStrength, strength), &at(kKnownCorners, corners)},
            &weights_[kKnownMixes + mix]};
  }
  /// Of a voxel among free ones.
  BitModel& sort_inside(std::size_t strength) { return at(kSortStrength, strength); }
  Mixed sort(std::size_t faces, std::size_t strength, std::size_t corners, std::size_t mix) {
    return {{&at(kSortFaces, faces), &at(kSortStrength, strength), &at(kSortCorners, corners)},
            &weights_[kSortMixes + mix]};
  }
  /// `sort`: 0 free, 1 occupied. `node`: 1..7.
  Mixed steps(std::size_t sort, std::size_t node, std::size_t rank, std::size_t below, std::size_t pattern) {
    const std::size_t n = node - 1;
    return {
        {&at(kStepRanks, (sort * 165 + rank) * kStepNodes + n), &at(kStepBelow, (sort * 144 + below) * kStepNodes + n),
         &at(kStepPattern, (sort * 360 + pattern) * kStepNodes + n)},
        &weights_[kStepMixes + sort * kStepNodes + n]};
  }
  BitModel& odd(std::size_t sort, std::size_t steps, std::size_t around) {
    return at(kOddGroup, (sort * 8 + steps) * 8 + around);
  }
  BitModel& has_colour(std::size_t last) { return at(kFlagGroup, last); }
  /// Contexts: 0..15 each. `node`: below kMixedNodes.
  Mixed colour(std::size_t channel, const std::array<std::size_t, kMixed>& contexts, std::size_t node) {
    const auto place = [&](std::size_t i) { return ((channel * 3 + i) * 16 + contexts[i]) * kMixedNodes + node; };
    return {{&at(kColourGroup, place(0)), &at(kColourGroup, place(1)), &at(kColourGroup, place(2))},
            &weights_[kColourMixes + channel * kMixedNodes + node]};
  }
  /// The first two bits behind the highest of a difference of `width` bits, which is 2..8.
  BitModel& colour_top(std::size_t channel, std::size_t width, std::size_t node) {
    return at(kTopGroup, (channel * 7 + width - 2) * 4 + node);
  }

  /// For training.
  [[nodiscard]] std::size_t index_of(const BitModel& model) const {
    return static_cast<std::size_t>(&model - models_.data());
  }
  [[nodiscard]] std::size_t index_of(const MixWeights& weights) const {
    return static_cast<std::size_t>(&weights - weights_.data());
  }

 private:
  BitModel& at(const ModelGroup& group, std::size_t context) {
    const std::size_t index = group.begin + context;
    BitModel& model = models_[index];
    if (model.epoch != epoch_) {
      model = start_models_[index];
      model.epoch = epoch_;
    }
    return model;
  }

  const StartModels& start_models_;
  const StartWeights& start_weights_;
  StartModels models_{};
  StartWeights weights_;
  std::uint32_t epoch_ = 0;
};

}  // namespace g3d::net
