// SPDX-License-Identifier: Apache-2.0
#include "estimation/ekf.hpp"
#include "waymark/interface/sensor.hpp"

namespace waymark {

PredictedInnovation Prediction::innovation(const Update& update) const {
  constexpr int kNoBlock = 0;
  Linearization model;
  update.linearize({belief.mean, nullptr}, model);
  estimation::StateJacobian H;
  H.reset(model.rows(), layout.size());
  estimation::scatter(layout, kNoBlock, model, H);
  estimation::ekf::Innovation innovation;
  estimation::ekf::innovate(belief, model, H, innovation);
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
