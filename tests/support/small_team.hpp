// SPDX-License-Identifier: Apache-2.0
// Several navigators on round bodies in one flat world that all know already. Each drives to the places of its own
// list, one after the other, and tells the others of itself, late and not always. For tests of how they get by one
// another: no camera helps them, and who meets is judged by the bodies.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "hal/sim/seeded_random.hpp"
#include "nav/navigator.hpp"
#include "tests/support/kinematic_robot.hpp"
#include "tests/support/voxel_floor.hpp"

namespace g3d::tests {

/// What a robot is to do: places in their order, again and again; one that fails comes after the others.
class ErrandChooser final : public nav::GoalChooser {
 public:
  explicit ErrandChooser(std::vector<hal::PlanarPose> places) : places_(std::move(places)) {}
  void prepare(const nav::CellGrid<nav::CellState>&, const nav::CellGrid<std::uint8_t>&) override {}
  [[nodiscard]] std::optional<nav::Decision> decide(const nav::CellGrid<nav::CellState>&,
                                                    const nav::CellGrid<std::uint8_t>&, std::span<const std::uint32_t>,
                                                    const hal::PlanarPose&, hal::TimeNs) override;
  void goal_reached() override { go_on(true); }
  void goal_failed(nav::GoalFailure) override { go_on(false); }
  void start_again() override {}
  void set_home(const hal::PlanarPose&) override {}
  void set_energy_left(double) override {}
  void return_home(bool) override {}
  [[nodiscard]] std::span<const std::uint32_t> frontier_cells() const override { return {}; }
  [[nodiscard]] int reached() const { return reached_; }
  [[nodiscard]] int failed() const { return failed_; }

 private:
  void go_on(bool is_reached) {
    ++(is_reached ? reached_ : failed_);
    next_ = (next_ + 1) % places_.size();
    is_new_ = true;
  }
  std::vector<hal::PlanarPose> places_;
  std::size_t next_ = 0;
  bool is_new_ = true;
  int reached_ = 0;
  int failed_ = 0;
};

struct SmallTeamOptions {
  double word_period_s = 0.1;
  double word_delay_s = 0.1;
  double loss = 0.0;
  std::uint64_t seed = 1;
};

class SmallTeam {
 public:
  struct Plan {
    hal::PlanarPose start;
    std::vector<hal::PlanarPose> places;
  };
  SmallTeam(const std::vector<Box>& walls, const Box& extent, const std::vector<Plan>& plans,
            const SmallTeamOptions& options = {});

  void step();
  /// Until everybody has been to so many of its places, or the time is over. Whether they have.
  bool run_until_each_reached(int places, double limit_s);
  [[nodiscard]] double time_s() const { return static_cast<double>(now_) * 1e-9; }
  /// Between two bodies, ever; below 0 they have met.
  [[nodiscard]] double least_gap_m() const { return least_gap_m_; }
  [[nodiscard]] int wall_contacts() const;
  [[nodiscard]] const ErrandChooser& errands(std::size_t i) const { return *members_[i]->errands; }
  [[nodiscard]] nav::Navigator& navigator(std::size_t i) { return *members_[i]->navigator; }
  [[nodiscard]] const hal::PlanarPose& pose(std::size_t i) const { return members_[i]->robot.pose(); }
  /// From now on it says nothing and drives no more.
  void kill(std::size_t i) { members_[i]->is_dead = true; }

 private:
  struct Word {
    hal::TimeNs at = 0;  ///< when it comes in
    std::size_t from = 0;
    nav::Teammate mate;
  };
  struct Member {
    explicit Member(KinematicRobot body) : robot(std::move(body)) {}
    KinematicRobot robot;
    ErrandChooser* errands = nullptr;
    std::unique_ptr<nav::Navigator> navigator;
    nav::TeamSight sight;
    std::deque<Word> mail;
    bool is_dead = false;
  };
  void speak();
  void listen(Member& member);

  SmallTeamOptions options_;
  VoxelFloor floor_;
  std::vector<std::unique_ptr<Member>> members_;
  hal::SeededRandom random_;
  hal::TimeNs now_ = 0;
  hal::TimeNs next_word_ = 0;
  double least_gap_m_ = 100.0;
};

/// Walls around a rectangle.
[[nodiscard]] std::vector<Box> walls_around(const Box& inner, double thick_m = 0.15);

}  // namespace g3d::tests
