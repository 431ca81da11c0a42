// SPDX-License-Identifier: Apache-2.0
// How well this base knows by how much it has turned, against what the prior takes it for. A Kobuki's gyro is better by
// an order of magnitude than the worst that alignment has to bear, and to believe coarse, noisy images more than it
// spoils the way (rooms of 45 m, 160x120: by 0.9 m in seven minutes with odometry that was exact).
//
// What the image alone would say of a turn (the innovation) differs from odometry by the errors of both. Its mean
// square, less what the image is known to err by, is odometry's own (innovation-based adaptive filtering: Mehra 1972).
// Over half a minute; and over the last two seconds, so that wheels that begin to slip are noticed. The same for the
// way itself was tried: there images err by as much as odometry does, and what is left is noise. Thread: one. Allocates
// nothing.
#pragma once

#include "mapper/align/motion_prior.hpp"

namespace g3d::mapper::align {

class OdometryTrust {
 public:
  /// A step was corrected by `correction`, in planar motion; matrices as in prior_information(). `information`: of the
  /// image. `used`: the prior of that fit, `model`: the one that odometry's noise is stated by.
  void learn(const Vector6& correction, const Matrix6& information, const Matrix6& used, const Matrix6& model,
             double time_s);

  /// The model's variances of turning are to be multiplied by this.
  [[nodiscard]] double turn_scale() const;
  [[nodiscard]] OdometryNoise scaled(const OdometryNoise& model) const;

 private:
  struct Mean {
    double own2 = 0.0;  ///< of odometry's errors, squared
    double model2 = 0.0;
  };
  Mean long_, short_;
  double known_s_ = 0.0;
};

}  // namespace g3d::mapper::align
