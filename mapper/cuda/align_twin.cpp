// SPDX-License-Identifier: Apache-2.0
#include "mapper/cuda/align_twin.hpp"

#include <algorithm>
#include <cstring>

namespace g3d::mapper::cuda {

bool AlignTwin::can(Card& card, const align::SampleShape& shape, const align::SurfaceMap& mirror,
                    const align::FitQuestion& question) {
  // Threads look for an empty slot until they find one: there must be some, whatever one frame adds.
  const auto tiles = static_cast<std::size_t>(shape.columns) * static_cast<std::size_t>(shape.rows);
  return card.surface_slots() == mirror.table().size() && 4 * tiles < mirror.table().size() && shape.most_chosen >= 0 &&
         static_cast<std::uint32_t>(shape.most_chosen) <= kMostChosen && question.most_steps >= 0 &&
         question.most_steps <= kMostFitSteps;
}

bool AlignTwin::send(Card& card, const align::SurfaceMap& mirror) {
  const auto table = mirror.table();
  const Alignment& to = card.alignment();
  for (std::size_t first = 0; first < table.size(); first += to.cell_room) {
    const auto part = table.subspan(first, std::min<std::size_t>(to.cell_room, table.size() - first));
    std::copy(part.begin(), part.end(), to.cells);
    if (!card.import_cells(static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(part.size()))) return false;
  }
  return true;
}

bool AlignTwin::is_sane(const AlignState& state, const align::FitQuestion& question) {
  if (state.chosen > kMostChosen || state.steps > static_cast<std::uint32_t>(question.most_steps)) return false;
  for (const align::NormalSums* sums : {&state.sums[0], &state.sums[state.steps]}) {
    if (sums->matched < 0 || sums->matched > static_cast<std::int64_t>(state.chosen)) return false;
    if (sums->square < 0 || sums->cost < 0) return false;
  }
  return hal::is_valid(state.pose);
}

bool AlignTwin::fit(Card& card, const hal::Frame& frame, const align::SampleShape& shape,
                    const align::SurfaceMap& mirror, const align::FitQuestion& question, align::CardFit& fitted) {
  if (!is_there_ && !send(card, mirror)) return false;
  is_there_ = true;
  if (!card.begin_fit()) return false;
  AlignQuestion& asked = *card.alignment().question;
  asked = {};
  asked.shape = shape;
  asked.rule = mirror.options().rule;
  asked.fit = question;
  const auto pixels = static_cast<std::size_t>(shape.width_px * shape.rows * shape.tile_px);
  std::memcpy(card.depth(), frame.depth.get(), pixels * sizeof(std::uint16_t));
  if (!card.finish_fit()) return false;
  const AlignState state = *card.alignment().state;  // whoever shares it may write there at any time
  if (!is_sane(state, question)) return false;
  fitted.chosen = state.chosen;
  fitted.answer = {state.pose, state.sums[0], state.sums[state.steps]};
  return true;
}

bool AlignTwin::add(Card& card, const hal::RigidTransform& T_world_camera, hal::TimeNs stamp_ns, bool looks_at_map,
                    float resolution_m, align::SurfaceMap& mirror) {
  AlignQuestion& asked = *card.alignment().question;
  asked.T_world_camera = T_world_camera;
  asked.stamp_ns = stamp_ns;
  asked.frame = mirror.next_frame();
  asked.takes_new = mirror.takes_new_cells() ? 1 : 0;
  asked.looks_at_map = looks_at_map ? 1 : 0;
  asked.resolution_m = resolution_m;
  asked.swept_first = static_cast<std::uint32_t>(mirror.next_swept().first);
  asked.swept_end = static_cast<std::uint32_t>(mirror.next_swept().end);
  if (!card.add_samples()) return false;
  const Alignment& alignment = card.alignment();
  const std::uint32_t touched = alignment.state->touched;
  return touched <= alignment.cell_room &&
         mirror.take({alignment.cells, touched}, alignment.state->refused, looks_at_map);
}

}  // namespace g3d::mapper::cuda
