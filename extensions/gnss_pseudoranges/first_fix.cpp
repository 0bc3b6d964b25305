// SPDX-License-Identifier: Apache-2.0
#include "first_fix.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "earth.hpp"

namespace waymark::gnss {
namespace {

constexpr int kMostStates = 3 + kMaxBlockStates;
using State = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostStates, 1>;
using Normal = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostStates, kMostStates>;

struct Signal {
  Eigen::Vector3d p_ecef;
  int clock;        // place of its clock in the state
  double range;     // less the mean of its noise [m]
  double variance;  // of its noise [m²]
};

/// The satellites that are used. Elevations are known once there is a position.
std::vector<Signal> signals(const Pseudoranges& epoch, const Receiver& receiver, const State* at) {
  std::vector<Signal> out;
  out.reserve(epoch.satellites.size());
  for (const auto& one : epoch.satellites) {
    const int system = receiver.find_system(one.system);
    if (system < 0 || !std::isfinite(one.range_m) || !one.p_ecef_m.allFinite()) continue;
    if (at != nullptr) {
      const Eigen::Vector3d up = at->head<3>().normalized();
      const double elevation = std::asin(up.dot((one.p_ecef_m - at->head<3>()).normalized()));
      if (elevation < receiver.least_elevation()) continue;
    }
    const Moments noise = receiver.noise(one).moments();
    out.push_back({one.p_ecef_m, 3 + system, one.range_m - noise.mean, noise.variance});
  }
  return out;
}

struct Solution {
  State x;
  Normal covariance;
};

/// Gauss–Newton. `robust`: weights by the residuals.
std::optional<Solution> solve(const std::vector<Signal>& all, State x, bool robust) {
  constexpr int kSteps = 12;
  constexpr double kSettled = 1e-2;  // [m]
  for (int step = 0; step < kSteps; ++step) {
    Normal N = 1e-12 * Normal::Identity(x.size(), x.size());  // a clock that no satellite shows stays
    State b = State::Zero(x.size());
    for (const Signal& signal : all) {
      const Eigen::Vector3d p = x.head<3>();
      const double turned = kRotation / kLight * (signal.p_ecef - p).norm();
      const Eigen::Vector3d d = p - Eigen::AngleAxisd(-turned, Eigen::Vector3d::UnitZ()) * signal.p_ecef;
      State h = State::Zero(x.size());
      h.head<3>() = d.normalized();
      h[signal.clock] = 1.0;
      const double residual = signal.range - d.norm() - x[signal.clock];
      const double weight = 1.0 / (signal.variance + (robust ? residual * residual : 0.0));
      N += weight * h * h.transpose();
      b += weight * residual * h;
    }
    const Eigen::LDLT<Normal> factor(N);
    const State dx = factor.solve(b);
    if (factor.info() != Eigen::Success || !dx.allFinite()) return std::nullopt;
    x += dx;
    if (dx.norm() < kSettled) return Solution{x, factor.solve(Normal::Identity(x.size(), x.size()))};
  }
  return std::nullopt;
}

}  // namespace

std::optional<FirstFix> first_fix(const Pseudoranges& epoch, const Receiver& receiver) {
  const auto all = signals(epoch, receiver, nullptr);
  int systems = 0;
  for (const Signal& signal : all) systems = std::max(systems, signal.clock - 2);
  if (systems == 0 || static_cast<int>(all.size()) < 4 + systems) return std::nullopt;
  const auto rough = solve(all, State::Zero(3 + systems), false);
  if (!rough) return std::nullopt;
  const auto used = signals(epoch, receiver, &rough->x);
  if (static_cast<int>(used.size()) < 4 + systems) return std::nullopt;
  const auto found = solve(used, rough->x, true);
  if (!found || std::abs(to_datum(found->x.head<3>()).height_m) > 2e4) return std::nullopt;
  const Eigen::Vector3d up = found->x.head<3>().normalized();
  const Eigen::Matrix3d P = found->covariance.topLeftCorner<3, 3>();
  const double sigma = std::sqrt(0.5 * (P.trace() - up.dot(P * up)));
  constexpr double kCertain = 100.0;  // [m]
  if (!(sigma < kCertain)) return std::nullopt;
  return FirstFix{found->x.head<3>(), sigma};
}

}  // namespace waymark::gnss
