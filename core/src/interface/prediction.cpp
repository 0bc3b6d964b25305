// SPDX-License-Identifier: Apache-2.0
#include "estimation/ekf.hpp"
#include "waymark/interface/sensor.hpp"

namespace waymark {

PredictedInnovation Prediction::innovation(const Update& update) const {
  constexpr int kNoOwner = 0;  // the update has no block, so nobody's place in the layout is asked for
  Linearization model;
  update.linearize({belief.mean, nullptr}, model);
  estimation::ekf::Innovation innovation;
  estimation::ekf::innovate(belief, layout, kNoOwner, model, innovation);
  return {innovation.nu, innovation.S};
}

Eigen::Vector3d Prediction::velocity_variance() const {
  constexpr int kFirstOfVelocity = 6;
  Eigen::Vector3d variance = Eigen::Vector3d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const int state = layout.active(kFirstOfVelocity + axis);
    if (state >= 0) variance[axis] = belief.P(state, state);
  }
  return variance;
}

}  // namespace waymark
