// SPDX-License-Identifier: Apache-2.0
#include "nav/view_tour.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace g3d::nav {
namespace {

constexpr std::int32_t kAnyway = TravelField::kNever - 100;  ///< however far; steps may be added to it
constexpr int kRate_units = 12;                              // to find a place's best heading
constexpr int kRefine_units = 20;                            // to judge all headings of a place
constexpr int kSkip_units = 1;

double turn_between(double a, double b) { return std::abs(std::remainder(a - b, 6.283185307179586)); }

}  // namespace

void Targets::reset(int columns, int rows) {
  columns_ = static_cast<std::uint32_t>(columns);
  target_columns_ = static_cast<std::uint32_t>((columns + 3) / 4);
  size_ = static_cast<std::size_t>(target_columns_) * static_cast<std::size_t>((rows + 3) / 4);
}

void ViewTour::reset(const RoadGrid& roads, const Targets& targets, const TourConfig& config, int window) {
  config_ = config;
  window_ = window;
  covered_in_.assign(targets.size(), 0);
  round_ = 0;
  const std::size_t stops = static_cast<std::size_t>(config_.max_views) + 1;
  heap_.reserve(Viewpoints::kMaxPlaces);
  views_.reserve(stops);
  tour_.reserve(stops);
  order_.reset(static_cast<std::size_t>(config_.max_views), {config_.length_weight, config_.keep_s, config_.passes});
  roads.size_field(field_);
}

ViewTour::Best ViewTour::best_window(const Place& place, const Targets& targets,
                                     std::span<const std::uint8_t> ignored) const {
  std::array<float, kBearings> cells{};
  for (std::size_t ray = 0; ray < kViewRays; ++ray) {
    const RayGain& gain = place.gain[ray];
    if (gain.entry == RayGain::kNothing) continue;
    const std::uint32_t target = targets.of_cell(gain.entry);
    if (covered_in_[target] == round_ || ignored[target] != 0) continue;
    cells[ray / kRaysPerBearing] += gain.cells;
  }
  float sum = 0.0F;
  for (int k = 0; k < window_; ++k) sum += cells[static_cast<std::size_t>(k)];
  Best best{sum, 0};
  int ties = 1;
  for (int first = 1; first < kBearings; ++first) {
    // Summed anew: a running sum would gather rounding errors, and ties decide headings.
    sum = 0.0F;
    for (int k = 0; k < window_; ++k) sum += cells[static_cast<std::size_t>((first + k) % kBearings)];
    if (sum > best.gain + 1e-3F) {
      best = {sum, first};
      ties = 1;
    } else if (sum > best.gain - 1e-3F && first == best.first_bearing + ties) {
      ++ties;
    }
  }
  // In the middle of equally good headings, so that what it shows is not at the rim of the view.
  best.first_bearing = (best.first_bearing + (ties - 1) / 2) % kBearings;
  return best;
}

double ViewTour::gain_of(const PanoramaGain& gain, int first_bearing, const Targets& targets,
                         std::span<const std::uint8_t> ignored) const {
  double sum = 0;
  for (int k = 0; k < window_ * kRaysPerBearing; ++k) {
    const RayGain& ray = gain[static_cast<std::size_t>((first_bearing * kRaysPerBearing + k) % kViewRays)];
    if (ray.entry != RayGain::kNothing && ignored[targets.of_cell(ray.entry)] == 0)
      sum += static_cast<double>(ray.cells);
  }
  return sum;
}

void ViewTour::take(const Viewpoints& places, const Targets& targets, std::uint32_t slot, const Best& best) {
  const Place& place = places.place(slot);
  View view;
  view.slot = slot;
  view.road = place.road;
  view.first_bearing = best.first_bearing;
  view.heading_rad = std::remainder((best.first_bearing + window_ / 2.0) * kBearing_rad, 6.283185307179586);
  view.gain_cells = best.gain;
  views_.push_back(view);
  for (int k = 0; k < window_ * kRaysPerBearing; ++k) {
    const RayGain& ray = place.gain[static_cast<std::size_t>((best.first_bearing * kRaysPerBearing + k) % kViewRays)];
    if (ray.entry != RayGain::kNothing) covered_in_[targets.of_cell(ray.entry)] = round_;
  }
}

double ViewTour::least_cells(const TourScene& scene, const Place& place) const {
  const double tenth_s = scene.roads.step_m() / 10 / config_.speed_mps;
  return config_.min_gain_cells + config_.gain_per_drive_s * scene.from_robot.distance[place.road] * tenth_s;
}

float ViewTour::score(const TourScene& scene, const Place& place, float gain) const {
  const double s = scene.from_robot.distance[place.road] * (scene.roads.step_m() / 10 / config_.speed_mps);
  return gain * static_cast<float>(1.0 / (config_.near_s + s));
}

void ViewTour::take_kept(const TourScene& scene) {
  has_kept_ = false;
  if (!kept_) return;
  const double gain = gain_of(scene.places.place(kept_->slot).gain, kept_->first_bearing, scene.targets, scene.ignored);
  has_kept_ = gain >= config_.min_gain_cells;
  if (has_kept_) take(scene.places, scene.targets, kept_->slot, {static_cast<float>(gain), kept_->first_bearing});
}

/// Every place with what it would show if it were the next.
bool ViewTour::rate(const TourScene& scene, WorkBudget& budget) {
  if (is_first_) {
    is_first_ = false;
    ++round_;
    take_kept(scene);
  }
  for (; next_ < scene.places.useful().size(); ++next_) {
    if (budget.is_spent()) return false;
    const std::uint32_t slot = scene.places.useful()[next_];
    const Place& place = scene.places.place(slot);
    budget.spend(kSkip_units);
    if (static_cast<double>(place.total_cells) < config_.min_gain_cells || !scene.allowed(place)) continue;
    budget.spend(kRate_units);
    const Best best = best_window(place, scene.targets, scene.ignored);
    if (static_cast<double>(best.gain) >= least_cells(scene, place)) {
      heap_.push_back({score(scene, place, best.gain), slot});
    }
  }
  std::make_heap(heap_.begin(), heap_.end(), is_worse);
  return true;
}

/// Greedy set cover: what a place shows only shrinks while others are taken, so the best of old bounds is tried first.
bool ViewTour::choose(const TourScene& scene, WorkBudget& budget) {
  while (!heap_.empty() && views_.size() < static_cast<std::size_t>(config_.max_views)) {
    if (budget.is_spent()) return false;
    budget.spend(kRate_units);
    const Candidate top = heap_.front();
    std::pop_heap(heap_.begin(), heap_.end(), is_worse);
    heap_.pop_back();
    const Place& place = scene.places.place(top.index);
    const Best best = best_window(place, scene.targets, scene.ignored);
    if (static_cast<double>(best.gain) < least_cells(scene, place)) continue;
    const Candidate again{score(scene, place, best.gain), top.index};
    const bool still_best = heap_.empty() || !is_worse(again, heap_.front());
    if (still_best) take(scene.places, scene.targets, top.index, best);
    heap_.push_back(again);
    std::push_heap(heap_.begin(), heap_.end(), is_worse);
  }
  return true;
}

double ViewTour::seconds_to(const RoadGrid& roads, const TravelField& field, const hal::PlanarPose& from,
                            std::uint32_t from_road, std::uint32_t to_road, double heading_rad) const {
  if (field.distance[to_road] == TravelField::kNever) return 1e4;
  if (to_road == from_road) return turn_between(heading_rad, from.heading_rad) / config_.turn_radps;
  const double leave = roads.leave_heading(field, from_road, to_road);
  const double arrive = roads.arrive_heading(field, to_road);
  return field.distance[to_road] * roads.step_m() / 10 / config_.speed_mps +
         (turn_between(leave, from.heading_rad) + turn_between(heading_rad, arrive)) / config_.turn_radps;
}

bool ViewTour::measure(const TourScene& scene, WorkBudget& budget) {
  if (next_ == 0) order_.begin(views_.size(), has_kept_);
  std::int32_t farthest = 0;
  for (const View& view : views_) {
    const std::int32_t tenths = scene.from_robot.distance[view.road];
    if (tenths != TravelField::kNever) farthest = std::max(farthest, tenths);
  }
  for (; next_ <= views_.size(); ++next_) {
    if (budget.is_spent()) return false;
    const bool is_robot = next_ == 0;
    if (!is_robot) {
      const View& from = views_[next_ - 1];
      // No view is farther than by way of the robot: in a large building that spares most of it.
      if (is_first_) {
        const std::int32_t tenths = scene.from_robot.distance[from.road];
        scene.roads.begin_travel(from.road, tenths == TravelField::kNever ? kAnyway : tenths + farthest, field_);
      }
      is_first_ = false;
      if (!scene.roads.go_on(field_, budget)) return false;
      order_.set_worth(next_, static_cast<double>(from.gain_cells));
    }
    is_first_ = true;
    const TravelField& field = is_robot ? scene.from_robot : field_;
    const std::uint32_t road = is_robot ? scene.from_robot.reached.front() : views_[next_ - 1].road;
    const hal::PlanarPose pose = is_robot ? scene.robot : hal::PlanarPose{0, 0, views_[next_ - 1].heading_rad};
    for (std::size_t j = 1; j <= views_.size(); ++j) {
      const View& to = views_[j - 1];
      order_.set_seconds(next_, j,
                         config_.stop_s + seconds_to(scene.roads, field, pose, road, to.road, to.heading_rad));
    }
  }
  return true;
}

/// The first view may stand elsewhere and look elsewhere if that saves more time, on the way to the second one too,
/// than what it shows less is worth. Seconds and cells are compared at the rate of the tour.
void ViewTour::begin_refining(const TourScene& scene) {
  double cells = 0;
  double seconds = 0;
  std::size_t at = 0;
  for (const std::uint16_t k : order_.order()) {
    seconds += order_.seconds(at, k);
    cells += static_cast<double>(views_[k - 1U].gain_cells);
    at = k;
  }
  refining_ = {tour_.front(), 0.0, seconds / cells, -1e18};
  // Its task: the targets that it was chosen for.
  ++round_;
  const View& first = refining_.first;
  for (int k = 0; k < window_ * kRaysPerBearing; ++k) {
    const RayGain& ray = scene.places.place(first.slot)
                             .gain[static_cast<std::size_t>((first.first_bearing * kRaysPerBearing + k) % kViewRays)];
    if (ray.entry == RayGain::kNothing || scene.ignored[scene.targets.of_cell(ray.entry)] != 0) continue;
    covered_in_[scene.targets.of_cell(ray.entry)] = round_;
    refining_.task_cells += static_cast<double>(ray.cells);
  }
}

bool ViewTour::refine(const TourScene& scene, WorkBudget& budget) {
  const double tenth_s = scene.roads.step_m() / 10 / config_.speed_mps;
  for (; next_ < scene.places.useful().size(); ++next_) {
    if (budget.is_spent()) return false;
    const std::uint32_t slot = scene.places.useful()[next_];
    const Place& place = scene.places.place(slot);
    const double drive_s = scene.from_robot.distance[place.road] * tenth_s;
    budget.spend(kSkip_units);
    if (static_cast<double>(place.total_cells) < config_.min_gain_cells) continue;
    if (static_cast<double>(place.total_cells) * refining_.worth_s - drive_s < refining_.best) continue;
    if (!scene.allowed(place)) continue;
    budget.spend(kRefine_units);
    try_first(scene, slot);
  }
  return true;
}

void ViewTour::try_first(const TourScene& scene, std::uint32_t slot) {
  constexpr double kPi = 3.141592653589793;
  const Place& place = scene.places.place(slot);
  const RoadGrid& roads = scene.roads;
  const double tenth_s = roads.step_m() / 10 / config_.speed_mps;
  const double drive_s = scene.from_robot.distance[place.road] * tenth_s;
  const bool has_second = tour_.size() > 1;
  const View second = has_second ? tour_[1] : View{};
  const std::uint32_t start = scene.from_robot.reached.front();
  std::array<double, kBearings> show{};
  for (std::size_t ray = 0; ray < kViewRays; ++ray) {
    const RayGain& gain = place.gain[ray];
    if (gain.entry == RayGain::kNothing || covered_in_[scene.targets.of_cell(gain.entry)] != round_) continue;
    show[ray / kRaysPerBearing] += static_cast<double>(gain.cells);
  }
  double arrive = scene.robot.heading_rad;
  double turn_in = 0;
  if (place.road != start) {
    arrive = roads.arrive_heading(scene.from_robot, place.road);
    turn_in = turn_between(roads.leave_heading(scene.from_robot, start, place.road), scene.robot.heading_rad);
  }
  double on_s = 0;
  double leave = 0;
  const bool moves_on = has_second && place.road != second.road && field_.distance[place.road] != TravelField::kNever;
  if (moves_on) {
    leave = roads.arrive_heading(field_, place.road) + kPi;
    const double reach = roads.leave_heading(field_, second.road, place.road) + kPi;
    on_s = field_.distance[place.road] * tenth_s + turn_between(reach, second.heading_rad) / config_.turn_radps;
  }
  for (int b = 0; b < kBearings; ++b) {
    double gain = 0;
    for (int k = 0; k < window_; ++k) gain += show[static_cast<std::size_t>((b + k) % kBearings)];
    if (gain < config_.task_share * refining_.task_cells) continue;
    const double heading = (b + window_ / 2.0) * kBearing_rad;
    double turns = turn_in + turn_between(heading, arrive);
    if (moves_on) turns += turn_between(leave, heading);
    if (has_second && place.road == second.road) turns += turn_between(second.heading_rad, heading);
    const double value = gain * refining_.worth_s - drive_s - on_s - turns / config_.turn_radps;
    if (value <= refining_.best) continue;
    refining_.best = value;
    View& v = tour_.front();
    v.slot = slot;
    v.road = place.road;
    v.first_bearing = b;
    v.heading_rad = std::remainder(heading, 2 * kPi);
    v.gain_cells = static_cast<float>(gain);
  }
}

std::span<const View> ViewTour::plan(const TourScene& scene) {
  begin();
  WorkBudget budget = WorkBudget::unlimited();
  (void)go_on(scene, budget);
  return tour_;
}

void ViewTour::begin() {
  tour_.clear();
  views_.clear();
  heap_.clear();
  enter(Phase::rating);
}

void ViewTour::enter(Phase phase) {
  phase_ = phase;
  next_ = 0;
  is_first_ = true;
}

bool ViewTour::go_on(const TourScene& scene, WorkBudget& budget) {
  while (phase_ != Phase::done) {
    if (budget.is_spent()) return false;
    switch (phase_) {
      case Phase::rating:
        if (!rate(scene, budget)) return false;
        enter(Phase::choosing);
        break;
      case Phase::choosing:
        if (!choose(scene, budget)) return false;
        enter(views_.empty() ? Phase::done : Phase::measuring);
        break;
      case Phase::measuring:
        if (!measure(scene, budget)) return false;
        enter(Phase::ordering);
        break;
      case Phase::ordering:
        if (!order_.go_on(budget)) return false;
        for (const std::uint16_t k : order_.order()) tour_.push_back(views_[k - 1U]);
        enter(order_.keeps_first() ? Phase::done : Phase::reaching_second);
        break;
      case Phase::reaching_second:
        if (is_first_) begin_refining(scene);
        if (is_first_ && tour_.size() > 1) {
          scene.roads.begin_travel(tour_[1].road, kAnyway, field_);
        }
        is_first_ = false;
        if (tour_.size() > 1 && !scene.roads.go_on(field_, budget)) return false;
        enter(Phase::refining);
        break;
      case Phase::refining:
        if (!refine(scene, budget)) return false;
        enter(Phase::done);
        break;
      case Phase::done:
        break;
    }
  }
  return true;
}

}  // namespace g3d::nav
