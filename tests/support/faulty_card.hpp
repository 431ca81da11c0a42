// SPDX-License-Identifier: Apache-2.0
// A card between a test and a good one, that fails and lies when it is told to.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <utility>

#include "mapper/cuda/card.hpp"

namespace g3d::test {

/// A card that passes everything on, until told to do something wrong.
class FaultyCard final : public mapper::cuda::Card {
 public:
  explicit FaultyCard(std::shared_ptr<mapper::cuda::Card> good) : good_(std::move(good)) {}
  mapper::cuda::FrameInput& input() override { return good_->input(); }
  std::uint16_t* depth() override { return good_->depth(); }
  std::uint8_t* rgb() override { return good_->rgb(); }
  const mapper::cuda::Parcels& parcels() override { return good_->parcels(); }
  std::uint32_t room() const override { return good_->room(); }
  bool import_blocks(std::uint32_t count) override { return good_->import_blocks(count) && !fails_to_import; }
  const mapper::cuda::Classes& classes() override { return good_->classes(); }
  std::uint32_t class_room() const override { return good_->class_room(); }
  bool begin_frame() override { return good_->begin_frame(); }
  bool finish_frame(mapper::cuda::FrameCounters& counters) override {
    const bool done = good_->finish_frame(counters);
    if (spoil) spoil(counters, good_->classes());
    return done && !fails_to_run;
  }
  bool send_blocks(std::uint32_t first) override {
    const bool done = good_->send_blocks(first);
    if (spoil_parcels) spoil_parcels(good_->parcels());
    return done && !fails_to_send;
  }

  bool set_columns(const mapper::ColumnTables& tables) override {
    return good_->set_columns(tables) && !fails_to_answer;
  }
  bool read_columns(std::uint32_t first) override {
    const bool done = good_->read_columns(first);
    if (spoil_columns) spoil_columns(good_->columns());
    return done && !fails_to_answer;
  }
  const mapper::cuda::Columns& columns() override { return good_->columns(); }
  std::uint32_t column_room() const override { return good_->column_room(); }
  const mapper::cuda::GridQuestion& grid_question() override { return good_->grid_question(); }
  std::uint32_t grid_room() const override { return good_->grid_room(); }
  bool spread_grid() override {
    const bool done = good_->spread_grid();
    if (spoil_distances) spoil_distances(good_->grid_question().distances);
    return done && !fails_to_answer;
  }
  const mapper::cuda::Alignment& alignment() override { return good_->alignment(); }
  std::uint32_t surface_slots() const override { return good_->surface_slots(); }
  bool import_cells(std::uint32_t first, std::uint32_t count) override {
    return good_->import_cells(first, count) && !fails_to_import;
  }
  bool begin_fit() override { return good_->begin_fit(); }
  bool finish_fit() override {
    const bool done = good_->finish_fit();
    if (spoil_alignment) spoil_alignment(good_->alignment());
    return done && !fails_to_answer;
  }
  bool add_samples() override {
    const bool done = good_->add_samples();
    if (spoil_alignment) spoil_alignment(good_->alignment());
    return done && !fails_to_answer;
  }
  const mapper::cuda::Queries& queries() override { return good_->queries(); }
  std::uint32_t ray_room() const override { return good_->ray_room(); }
  std::uint32_t look_room() const override { return good_->look_room(); }
  bool cast_rays(std::uint32_t count, float resolution_m) override {
    const bool done = good_->cast_rays(count, resolution_m);
    if (spoil_answers) spoil_answers(good_->queries());
    return done && !fails_to_answer;
  }
  bool count_looks(std::uint32_t count, const mapper::LookModel& model) override {
    const bool done = good_->count_looks(count, model);
    if (spoil_answers) spoil_answers(good_->queries());
    return done && !fails_to_answer;
  }

  bool fails_to_import = false;
  bool fails_to_run = false;
  bool fails_to_send = false;
  bool fails_to_answer = false;
  std::function<void(mapper::cuda::FrameCounters&, const mapper::cuda::Classes&)> spoil;
  std::function<void(const mapper::cuda::Parcels&)> spoil_parcels;
  std::function<void(const mapper::cuda::Queries&)> spoil_answers;
  std::function<void(const mapper::cuda::Columns&)> spoil_columns;
  std::function<void(std::uint32_t*)> spoil_distances;
  std::function<void(const mapper::cuda::Alignment&)> spoil_alignment;

 private:
  std::shared_ptr<mapper::cuda::Card> good_;
};

}  // namespace g3d::test
