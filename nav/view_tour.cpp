// SPDX-License-Identifier: Apache-2.0
#include "nav/view_tour.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace g3d::nav {
namespace {

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
  seconds_.assign(stops * stops, 0.0F);
  order_.reserve(stops);
  trial_.reserve(stops);
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

void ViewTour::choose(const Viewpoints& places, const TravelField& from_robot, const RoadGrid& roads,
                      const Targets& targets, std::span<const std::uint8_t> ignored,
                      const std::function<bool(const Place&)>& allowed) {
  ++round_;
  views_.clear();
  heap_.clear();
  const auto worse = [](const Candidate& a, const Candidate& b) {
    return a.score != b.score ? a.score < b.score : a.index > b.index;
  };
  has_kept_ = false;
  if (kept_ != nullptr) {
    const double gain = gain_of(places.place(kept_->slot).gain, kept_->first_bearing, targets, ignored);
    has_kept_ = gain >= config_.min_gain_cells;
    if (has_kept_) take(places, targets, kept_->slot, {static_cast<float>(gain), kept_->first_bearing});
  }
  const double tenth_s = roads.step_m() / 10 / config_.speed_mps;
  const auto least = [&](const Place& place) {
    return config_.min_gain_cells + config_.gain_per_drive_s * from_robot.distance[place.road] * tenth_s;
  };
  const auto nearness = [&](const Place& place) {
    const double s = from_robot.distance[place.road] * tenth_s;
    return static_cast<float>(1.0 / (config_.near_s + s));
  };
  for (const std::uint32_t slot : places.useful()) {
    const Place& place = places.place(slot);
    if (static_cast<double>(place.total_cells) < config_.min_gain_cells || !allowed(place)) continue;
    const Best best = best_window(place, targets, ignored);
    if (static_cast<double>(best.gain) >= least(place)) heap_.push_back({best.gain * nearness(place), slot});
  }
  std::make_heap(heap_.begin(), heap_.end(), worse);
  while (!heap_.empty() && views_.size() < static_cast<std::size_t>(config_.max_views)) {
    const Candidate top = heap_.front();
    std::pop_heap(heap_.begin(), heap_.end(), worse);
    heap_.pop_back();
    const Place& place = places.place(top.index);
    const Best best = best_window(place, targets, ignored);
    if (static_cast<double>(best.gain) < least(place)) continue;
    const Candidate again{best.gain * nearness(place), top.index};
    const bool still_best = heap_.empty() || !worse(again, heap_.front());
    if (still_best) take(places, targets, top.index, best);
    heap_.push_back(again);
    std::push_heap(heap_.begin(), heap_.end(), worse);
  }
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

void ViewTour::measure(RoadGrid& roads, const TravelField& from_robot, const hal::PlanarPose& robot) {
  const std::size_t n = views_.size() + 1;
  std::int32_t farthest = 0;
  for (const View& view : views_) farthest = std::max(farthest, from_robot.distance[view.road]);
  for (std::size_t i = 0; i < n; ++i) {
    const TravelField& field = i == 0 ? from_robot : field_;
    // No view is farther than by way of the robot: in a large building that spares most of it.
    if (i > 0) roads.travel(views_[i - 1].road, from_robot.distance[views_[i - 1].road] + farthest, field_);
    const std::uint32_t road = i == 0 ? from_robot.reached.front() : views_[i - 1].road;
    const hal::PlanarPose pose = i == 0 ? robot : hal::PlanarPose{0, 0, views_[i - 1].heading_rad};
    for (std::size_t j = 1; j < n; ++j) {
      seconds_[i * n + j] = static_cast<float>(
          config_.stop_s + seconds_to(roads, field, pose, road, views_[j - 1].road, views_[j - 1].heading_rad));
    }
  }
}

double ViewTour::price(std::span<const std::uint16_t> order) const {
  const std::size_t n = views_.size() + 1;
  double t = 0;
  double weighted = 0;
  double weight = 0;
  std::size_t at = 0;
  for (const std::uint16_t next : order) {
    t += static_cast<double>(seconds_[at * n + next]);
    const double w = static_cast<double>(views_[next - 1U].gain_cells);
    weighted += w * t;
    weight += w;
    at = next;
  }
  const bool keeps = has_kept_ && order[0] == 1;
  return weighted / weight + config_.length_weight * t - (keeps ? config_.keep_s : 0.0);
}

void ViewTour::order() {
  order_.clear();
  for (std::size_t next = 1; next <= views_.size(); ++next) {
    std::size_t best_at = 0;
    double best = 1e18;
    for (std::size_t at = 0; at <= order_.size(); ++at) {
      trial_.assign(order_.begin(), order_.end());
      trial_.insert(trial_.begin() + static_cast<std::ptrdiff_t>(at), static_cast<std::uint16_t>(next));
      const double p = price(trial_);
      if (p >= best) continue;
      best = p;
      best_at = at;
    }
    order_.insert(order_.begin() + static_cast<std::ptrdiff_t>(best_at), static_cast<std::uint16_t>(next));
  }
  const std::size_t n = order_.size();
  double best = price(order_);
  bool better = true;
  const auto keep = [&] {
    const double p = price(trial_);
    if (p >= best - 1e-6) return;
    best = p;
    order_.swap(trial_);
    better = true;
  };
  for (int pass = 0; pass < config_.passes && better; ++pass) {
    better = false;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = i + 1; j < n; ++j) {
        trial_.assign(order_.begin(), order_.end());
        std::reverse(trial_.begin() + static_cast<std::ptrdiff_t>(i),
                     trial_.begin() + static_cast<std::ptrdiff_t>(j) + 1);
        keep();
        for (std::size_t size = 1; size <= 3 && i + size <= n; ++size) {
          for (const bool forward : {true, false}) {
            // Moves `size` stops from i behind what is then at j, or the other way round.
            trial_.assign(order_.begin(), order_.end());
            const std::size_t low = i;
            const std::size_t high = std::min(j + size, n);
            const auto first = trial_.begin() + static_cast<std::ptrdiff_t>(low);
            const auto last = trial_.begin() + static_cast<std::ptrdiff_t>(high);
            if (high - low <= size) continue;
            const auto middle =
                forward ? first + static_cast<std::ptrdiff_t>(size) : last - static_cast<std::ptrdiff_t>(size);
            std::rotate(first, middle, last);
            keep();
          }
        }
      }
    }
  }
}

/// The first view may stand elsewhere and look elsewhere if that saves more time, on the way to the second one too,
/// than what it shows less is worth. Seconds and cells are compared at the rate of the tour.
void ViewTour::refine_first(const Viewpoints& places, RoadGrid& roads, const TravelField& from_robot,
                            const hal::PlanarPose& robot, const Targets& targets, std::span<const std::uint8_t> ignored,
                            const std::function<bool(const Place&)>& allowed) {
  double cells = 0;
  double seconds = 0;
  const std::size_t n = views_.size() + 1;
  std::size_t at = 0;
  for (const std::uint16_t k : order_) {
    seconds += static_cast<double>(seconds_[at * n + k]);
    cells += static_cast<double>(views_[k - 1U].gain_cells);
    at = k;
  }
  const double worth_s = seconds / cells;
  const bool has_second = tour_.size() > 1;
  const View second = has_second ? tour_[1] : View{};
  if (has_second) roads.travel(second.road, TravelField::kNever - 100, field_);
  // Its task: the targets that it was chosen for.
  ++round_;
  const View first = tour_.front();
  double task = 0;
  for (int k = 0; k < window_ * kRaysPerBearing; ++k) {
    const RayGain& ray = places.place(first.slot)
                             .gain[static_cast<std::size_t>((first.first_bearing * kRaysPerBearing + k) % kViewRays)];
    if (ray.entry == RayGain::kNothing || ignored[targets.of_cell(ray.entry)] != 0) continue;
    covered_in_[targets.of_cell(ray.entry)] = round_;
    task += static_cast<double>(ray.cells);
  }
  const std::uint32_t start = from_robot.reached.front();
  const double tenth_s = roads.step_m() / 10 / config_.speed_mps;
  constexpr double kPi = 3.141592653589793;
  double best = -1e18;
  for (const std::uint32_t slot : places.useful()) {
    const Place& place = places.place(slot);
    const double drive_s = from_robot.distance[place.road] * tenth_s;
    if (static_cast<double>(place.total_cells) < config_.min_gain_cells) continue;
    if (static_cast<double>(place.total_cells) * worth_s - drive_s < best || !allowed(place)) continue;
    std::array<double, kBearings> show{};
    for (std::size_t ray = 0; ray < kViewRays; ++ray) {
      const RayGain& gain = place.gain[ray];
      if (gain.entry == RayGain::kNothing || covered_in_[targets.of_cell(gain.entry)] != round_) continue;
      show[ray / kRaysPerBearing] += static_cast<double>(gain.cells);
    }
    double arrive = robot.heading_rad;
    double turn_in = 0;
    if (place.road != start) {
      arrive = roads.arrive_heading(from_robot, place.road);
      turn_in = turn_between(roads.leave_heading(from_robot, start, place.road), robot.heading_rad);
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
      if (gain < config_.task_share * task) continue;
      const double heading = (b + window_ / 2.0) * kBearing_rad;
      double turns = turn_in + turn_between(heading, arrive);
      if (moves_on) turns += turn_between(leave, heading);
      if (has_second && place.road == second.road) turns += turn_between(second.heading_rad, heading);
      const double value = gain * worth_s - drive_s - on_s - turns / config_.turn_radps;
      if (value <= best) continue;
      best = value;
      View& v = tour_.front();
      v.slot = slot;
      v.road = place.road;
      v.first_bearing = b;
      v.heading_rad = std::remainder(heading, 2 * kPi);
      v.gain_cells = static_cast<float>(gain);
    }
  }
}

std::span<const View> ViewTour::plan(const Viewpoints& places, RoadGrid& roads, const TravelField& from_robot,
                                     const hal::PlanarPose& robot, const Targets& targets,
                                     std::span<const std::uint8_t> ignored,
                                     const std::function<bool(const Place&)>& allowed) {
  tour_.clear();
  choose(places, from_robot, roads, targets, ignored, allowed);
  if (views_.empty()) return tour_;
  measure(roads, from_robot, robot);
  order();
  for (const std::uint16_t k : order_) tour_.push_back(views_[k - 1U]);
  const bool keeps = has_kept_ && order_[0] == 1;
  if (!keeps) refine_first(places, roads, from_robot, robot, targets, ignored, allowed);
  return tour_;
}

}  // namespace g3d::nav
