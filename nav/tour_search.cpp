// SPDX-License-Identifier: Apache-2.0
#include "nav/tour_search.hpp"

#include <algorithm>

namespace g3d::nav {
namespace {

constexpr int kLevels = 3;
constexpr std::int64_t kFrontierCellsPerUnit = 10;  // to mark the places around them
constexpr std::int64_t kFrontierCell_units = 2;     // to sort and to group it, and to look around it

}  // namespace

void TourSearch::reset(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost,
                       const SearchConfig& config) {
  config_ = config;
  camera_ = std::make_unique<ViewGain>(config.view, ground.resolution_m);
  frontiers_.reset(ground);
  roads_.reset(cost, config.body_radius_m);
  roads_.size_field(from_robot_);
  places_.reset(ground, roads_);
  targets_.reset(ground.columns, ground.rows);
  tour_.reset(roads_, targets_, config.tour, camera_->window());
  explanation_.reset(targets_.size());
  looked_.reserve(kViewRays);
  step_ = Step::done;
}

void TourSearch::take_changes(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost,
                              std::span<const std::uint32_t> changed) {
  if (changed.empty()) return;
  has_changed_ = true;
  frontiers_.update(ground, changed);
  roads_.update(cost, changed);
  places_.note_changes(changed);
}

std::optional<double> TourSearch::way_m(std::uint32_t road) const {
  const std::int32_t tenths = from_robot_.distance[road];
  if (tenths == TravelField::kNever) return std::nullopt;
  return tenths * roads_.step_m() / 10;
}

std::span<const RayGain> TourSearch::look(const CellGrid<CellState>& ground, Cell at, int first_bearing) {
  camera_->look(ground, at, panorama_);
  looked_.clear();
  for (int k = 0; k < camera_->window() * kRaysPerBearing; ++k) {
    looked_.push_back(panorama_[static_cast<std::size_t>((first_bearing * kRaysPerBearing + k) % kViewRays)]);
  }
  return looked_;
}

std::span<const RayGain> TourSearch::look_around(const CellGrid<CellState>& ground, Cell at) {
  camera_->look(ground, at, panorama_);
  return panorama_;
}

void TourSearch::begin(Cell at, const hal::PlanarPose& robot, const std::optional<KeptView>& kept,
                       std::function<bool(const Place&)> allowed) {
  robot_ = robot;
  kept_ = kept;
  allowed_ = std::move(allowed);
  roads_.begin_travel(roads_.road_of(at), TravelField::kNever - 100, from_robot_);
  step_ = Step::travelling;
  is_ahead_ = true;
  is_closer_ = false;
  places_.look_closer(false);
}

void TourSearch::begin_refresh(const CellGrid<CellState>& ground) {
  places_.begin_refresh(frontiers_, *camera_, ground.resolution_m, config_.max_casts);
  step_ = Step::refreshing;
}

// What is rich first, so that the tour is not drawn into every corner; then what is left.
void TourSearch::begin_tour() {
  const double least = config_.tour.min_gain_cells;
  tour_.set_min_gain(level_ + 1 < kLevels ? std::max(config_.rich_gains_cells[level_], least) : least);
  tour_.begin();
  step_ = Step::touring;
}

void TourSearch::begin_explaining() {
  explanation_.begin();
  step_ = Step::explaining;
}

void TourSearch::work_ahead(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost, WorkBudget& budget) {
  if (is_ahead_ && !has_changed_) return;
  if (is_ahead_) {
    has_changed_ = is_ahead_ = false;
    budget.spend(static_cast<std::int64_t>(frontiers_.cells().size()) / kFrontierCellsPerUnit);
    places_.begin_refresh(frontiers_, *camera_, ground.resolution_m, config_.max_casts);
  }
  is_ahead_ = places_.go_on(ground, cost, roads_, from_robot_, *camera_, budget);
}

bool TourSearch::go_on(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost, SetAside& aside,
                       WorkBudget& budget) {
  while (step_ != Step::done) {
    if (budget.is_spent()) return false;
    switch (step_) {
      case Step::travelling:
        if (!roads_.go_on(from_robot_, budget)) return false;
        begin_refresh(ground);
        break;
      case Step::refreshing: {
        if (!places_.go_on(ground, cost, roads_, from_robot_, *camera_, budget)) return false;
        const bool keeps = kept_ && places_.place(kept_->view.slot).cell == kept_->cell;
        tour_.keep(keeps ? std::optional(kept_->view) : std::nullopt);
        level_ = 0;
        begin_tour();
        break;
      }
      case Step::touring:
        if (!tour_.go_on({places_, roads_, from_robot_, robot_, targets_, aside.ignored(), allowed_}, budget)) {
          return false;
        }
        if (tour_.views().empty() && ++level_ < kLevels) {
          begin_tour();
        } else if (tour_.views().empty() && (!places_.is_complete() || aside.forget_claims() || aside.wake_all())) {
          begin_refresh(ground);
        } else if (tour_.views().empty() && !is_closer_) {
          is_closer_ = true;
          places_.look_closer(true);
          begin_refresh(ground);
        } else {
          begin_explaining();
        }
        break;
      case Step::explaining:
        if (!explanation_.note_seen(targets_, places_, budget)) return false;
        budget.spend(kFrontierCell_units * static_cast<std::int64_t>(frontiers_.cells().size()));
        frontiers_.make_clusters();
        left_ =
            explanation_.name_reasons(ground, frontiers_, targets_, aside, config_.view.near_m, !tour_.views().empty());
        step_ = Step::done;
        break;
      case Step::done:
        break;
    }
  }
  return true;
}

}  // namespace g3d::nav
