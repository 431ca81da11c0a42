// SPDX-License-Identifier: Apache-2.0
// A simulated building that runs by a clock, as real ones do: one thread steps it and moves the bytes between the bases
// and their pseudo-terminals, cameras take their frames whenever their time has come. The program on the other side is
// the one that drives a real robot.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "hal/clock.hpp"
#include "hal/depth_camera.hpp"
#include "hal/sim/base_cable.hpp"
#include "hal/sim/sim_building.hpp"

namespace g3d::hal {

class RealTimeBuilding {
 public:
  /// Begins to run at once; the building's time 0 is the clock's now. One pseudo-terminal per robot, with a link of
  /// that name if `links` has one. `clock` must outlive this.
  [[nodiscard]] static Result<std::unique_ptr<RealTimeBuilding>> start(World world, const SimBuildingOptions& options,
                                                                       Clock& clock,
                                                                       const std::vector<std::string>& links = {});
  /// The same with other cables, one per robot.
  [[nodiscard]] static std::unique_ptr<RealTimeBuilding> start(World world, const SimBuildingOptions& options,
                                                               Clock& clock,
                                                               std::vector<std::unique_ptr<BaseCable>> cables);
  ~RealTimeBuilding();
  RealTimeBuilding(const RealTimeBuilding&) = delete;
  RealTimeBuilding& operator=(const RealTimeBuilding&) = delete;

  [[nodiscard]] std::string path(std::size_t robot);
  /// Clock time at which the building began.
  [[nodiscard]] TimeNs begin_ns() const { return begin_ns_; }
  /// work(SimBuilding&, BaseCable& of the robot) while nothing moves. Any thread; keep it short.
  template <typename Work>
  auto with(std::size_t robot, const Work& work) {
    const std::lock_guard lock(mutex_);
    return work(building_, *cables_[robot]);
  }
  /// The largest delay of a step so far: above some ms the machine is too busy for real time.
  [[nodiscard]] TimeNs latest_step_ns() const { return latest_step_ns_.load(std::memory_order_relaxed); }

  /// One camera's end. Frames come at `rate_hz` of the clock and carry its time; a camera without power gives none.
  class Camera final : public DepthCamera {
   public:
    Camera(RealTimeBuilding& building, std::size_t robot, double rate_hz);
    [[nodiscard]] const CameraModel& model() const override { return model_; }
    [[nodiscard]] CameraRead read(Frame& out) override;
    /// read() says `end` from now on. Any thread.
    void stop() { stopped_.store(true, std::memory_order_release); }
    /// From where the last frame was taken, and when. The reading thread.
    [[nodiscard]] const SimBuilding::Glance& glance() const { return glance_; }

   private:
    RealTimeBuilding& building_;
    std::size_t robot_;
    CameraModel model_;
    TimeNs period_ns_;
    std::uint64_t next_ = 0;
    SimBuilding::Glance glance_;
    std::atomic<bool> stopped_{false};
  };

 private:
  RealTimeBuilding(World world, const SimBuildingOptions& options, Clock& clock,
                   std::vector<std::unique_ptr<BaseCable>> cables);
  void run();
  void join_line(std::size_t robot);

  Clock& clock_;
  TimeNs begin_ns_;
  TimeNs period_ns_;
  std::mutex mutex_;  ///< guards building_ and cables_
  SimBuilding building_;
  std::vector<std::unique_ptr<BaseCable>> cables_;
  std::vector<bool> lines_up_;  ///< the thread's
  std::atomic<bool> stop_{false};
  std::atomic<TimeNs> latest_step_ns_{0};  ///< written by the thread alone
  std::thread thread_;
};

}  // namespace g3d::hal
