// SPDX-License-Identifier: Apache-2.0
#include "pose_line.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <span>

#include "plugins/shared/json_messages/payload_text.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::json_poses {
namespace {

/// Appends `,"name":value`. JSON has no NaN and no infinity: null.
void append(std::string& text, std::string_view name, double value) {
  if (std::isfinite(value)) {
    fmt::format_to(std::back_inserter(text), ",\"{}\":{}", name, value);
  } else {
    fmt::format_to(std::back_inserter(text), ",\"{}\":null", name);
  }
}

}  // namespace

Estimate::Estimate(const StateLayout& layout) {
  for (std::size_t i = 0; i < active_.size(); ++i) active_[i] = layout.active(static_cast<int>(i));
}

Eigen::Matrix<double, 6, 6> Estimate::pose_covariance(const Belief& belief) const {
  Eigen::Matrix<double, 6, 6> P = Eigen::Matrix<double, 6, 6>::Zero();
  for (Eigen::Index row = 0; row < P.rows(); ++row) {
    for (Eigen::Index column = 0; column < P.cols(); ++column) {
      const int i = active_[static_cast<std::size_t>(row)];
      const int j = active_[static_cast<std::size_t>(column)];
      if (i >= 0 && j >= 0) P(row, column) = belief.P(i, j);
    }
  }
  return P;
}

std::string pose_line(const Belief& belief, const Estimate& estimate, const Health& health) {
  const NavState& mean = belief.mean;
  // q and -q are the same rotation: one sign, so that equal poses give equal text.
  const Eigen::Vector4d q = mean.T_map_base.q.w() < 0.0 ? Eigen::Vector4d(-mean.T_map_base.q.coeffs())
                                                        : Eigen::Vector4d(mean.T_map_base.q.coeffs());
  const Eigen::Vector3d& p = mean.T_map_base.p;
  std::string text = fmt::format("{{\"type\":\"pose\",\"stamp_ns\":{}", belief.stamp.time_since_epoch().count());
  append(text, "x_m", p.x());
  append(text, "y_m", p.y());
  append(text, "z_m", p.z());
  append(text, "yaw_rad", mean.T_map_base.yaw());
  append(text, "q_w", q.w());
  append(text, "q_x", q.x());
  append(text, "q_y", q.y());
  append(text, "q_z", q.z());
  append(text, "v_x_mps", mean.v_base.x());
  append(text, "v_y_mps", mean.v_base.y());
  append(text, "v_z_mps", mean.v_base.z());
  append(text, "w_x_radps", mean.w_base.x());
  append(text, "w_y_radps", mean.w_base.y());
  append(text, "w_z_radps", mean.w_base.z());
  const Eigen::Matrix<double, 6, 6> P = estimate.pose_covariance(belief);
  text += ",\"covariance\":";
  char before = '[';
  for (const double value : std::span(P.data(), static_cast<std::size_t>(P.size()))) {
    text += before;
    text += std::isfinite(value) ? fmt::format("{:.6g}", value) : std::string("null");
    before = ',';
  }
  fmt::format_to(std::back_inserter(text), "],\"health\":\"{}\"", to_string(health.state));
  if (!health.reason.empty())
    fmt::format_to(std::back_inserter(text), ",\"reason\":{}", json_messages::json_text(health.reason));
  return text + "}\n";
}

std::string twist_line(const Belief& belief, std::string_view sensor) {
  BodyTwist twist;
  twist.v_x_mps = belief.mean.v_base.x();
  twist.v_y_mps = belief.mean.v_base.y();
  twist.w_z_radps = belief.mean.w_base.z();
  return json_messages::write_message(sensor, belief.stamp, twist) + '\n';
}

std::string fix_line(const Belief& belief, const Estimate& estimate, std::string_view sensor) {
  const Eigen::Matrix<double, 6, 6> P = estimate.pose_covariance(belief);
  GnssFix fix;
  fix.p_map_antenna = belief.mean.T_map_base.p;
  fix.sigma_horizontal_m = std::sqrt(0.5 * (P(0, 0) + P(1, 1)));
  if (P(2, 2) > 0.0) fix.sigma_vertical_m = std::sqrt(P(2, 2));
  return json_messages::write_message(sensor, belief.stamp, fix) + '\n';
}

}  // namespace waymark::json_poses
