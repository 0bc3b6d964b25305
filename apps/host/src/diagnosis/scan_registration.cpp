// SPDX-License-Identifier: Apache-2.0
#include "scan_registration.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

namespace waymark::host::diagnosis {

namespace {

constexpr int kLeastPoints = 30;
constexpr double kNoReturn = 0.98;  // of the largest range
constexpr double kSurface = 0.15;   // neighbours on one surface are nearer than this share of their range
constexpr int kWindow = 12;         // points on either side among which the closest one is sought
constexpr int kIterations = 15;
constexpr double kFirstGate = 0.25;  // of the median range
constexpr double kLastGate = 0.02;
constexpr double kLeastInliers = 0.6;
constexpr double kStepRad = 0.05;       // of the angles that are tried first
constexpr int kSteps = 12;              // on either side
constexpr double kLeastSpread = 0.12;   // smaller eigenvalue of the normals' moments by the larger one
constexpr double kMostYawSigma = 0.01;  // [rad] of a result that counts

/// The points of a scan by bearing, for the search of the closest one.
struct Seeker {
  const std::vector<ThinScan::Point>& points;
  double first;
  double per_radian;

  explicit Seeker(const ThinScan& scan) : points(scan.points()), first(points.front().bearing) {
    per_radian = (static_cast<double>(points.size()) - 1.0) / std::max(points.back().bearing - first, 1e-6);
  }

  /// Index near a bearing; points are spread evenly enough for a guess that is then corrected.
  int near(double bearing) const {
    // Bearings grow from the first beam on.
    bearing = first + std::remainder(bearing - first - 0.5 * (points.back().bearing - first), 2.0 * M_PI) +
              0.5 * (points.back().bearing - first);
    int at = std::clamp(static_cast<int>((bearing - first) * per_radian), 0, static_cast<int>(points.size()) - 1);
    const auto bearing_of = [&](int k) { return points[static_cast<std::size_t>(k)].bearing; };
    while (at > 0 && bearing_of(at) > bearing) --at;
    while (at + 1 < static_cast<int>(points.size()) && bearing_of(at) < bearing) ++at;
    return at;
  }
};

struct Planar {
  Eigen::Vector2d t{0.0, 0.0};
  double yaw = 0.0;
  Eigen::Vector2d operator*(const Eigen::Vector2d& p) const {
    const double c = std::cos(yaw);
    const double s = std::sin(yaw);
    return {c * p.x() - s * p.y() + t.x(), s * p.x() + c * p.y() + t.y()};
  }
};

struct Pair {
  const ThinScan::Point* target = nullptr;
  double distance = 0.0;
};

Pair closest(const Seeker& seeker, const Eigen::Vector2d& p, int sign, double gate) {
  const int at = seeker.near(sign * std::atan2(p.y(), p.x()));
  const int last = static_cast<int>(seeker.points.size()) - 1;
  double best = gate * gate;
  const ThinScan::Point* found = nullptr;
  for (int k = std::max(0, at - kWindow); k <= std::min(last, at + kWindow); ++k) {
    const ThinScan::Point& candidate = seeker.points[static_cast<std::size_t>(k)];
    const double d2 = (candidate.p - p).squaredNorm();
    if (d2 < best) {
      best = d2;
      found = &candidate;
    }
  }
  return {found, std::sqrt(best)};
}

/// Of a turn alone: how badly the ranges fit, robustly.
double misfit(const Seeker& seeker, const ThinScan& second, double yaw, int sign, double gate) {
  double sum = 0.0;
  const std::vector<ThinScan::Point>& points = second.points();
  for (std::size_t k = 0; k < points.size(); k += 3) {
    // A turn about the sensor changes bearings, not ranges.
    const auto at = static_cast<std::size_t>(seeker.near(points[k].bearing + sign * yaw));
    sum += std::min(std::abs(seeker.points[at].p.norm() - points[k].p.norm()), gate);
  }
  return sum;
}

}  // namespace

ThinScan::ThinScan() {
  points_.reserve(kMost + 1);
  ranges_.reserve(kMost + 1);
}

bool ThinScan::take(const LaserScan& scan, double& largest) {
  points_.clear();
  ranges_.clear();
  const std::size_t beams = scan.ranges_m.size();
  if (beams < static_cast<std::size_t>(kLeastPoints) || scan.step_rad == 0.0) return false;
  for (const float range : scan.ranges_m) {
    if (std::isfinite(range)) largest = std::max(largest, static_cast<double>(range));
  }
  const std::size_t every = (beams + kMost - 1) / kMost;
  const double sign = scan.step_rad > 0.0 ? 1.0 : -1.0;
  // More than a turn would have two points at one bearing.
  const double most = 2.0 * M_PI;
  for (std::size_t k = 0; k < beams; k += every) {
    const double range = scan.ranges_m[k];
    const double turned = static_cast<double>(k) * std::abs(scan.step_rad);
    if (!std::isfinite(range) || range <= 0.0 || range >= kNoReturn * largest || turned >= most) continue;
    const double angle = scan.start_rad + static_cast<double>(k) * scan.step_rad;
    points_.push_back({{range * std::cos(angle), range * std::sin(angle)}, {0.0, 0.0}, sign * scan.start_rad + turned});
    ranges_.push_back(range);
  }
  if (points_.size() < static_cast<std::size_t>(kLeastPoints)) return false;
  const auto middle = ranges_.begin() + static_cast<std::ptrdiff_t>(ranges_.size() / 2);
  std::ranges::nth_element(ranges_, middle);
  median_ = *middle;
  for (std::size_t k = 1; k + 1 < points_.size(); ++k) {
    const Eigen::Vector2d along = points_[k + 1].p - points_[k - 1].p;
    const double near = kSurface * points_[k].p.norm();
    if ((points_[k + 1].p - points_[k].p).norm() > near || (points_[k - 1].p - points_[k].p).norm() > near) continue;
    points_[k].normal = Eigen::Vector2d(-along.y(), along.x()).normalized();
  }
  return true;
}

std::optional<ScanMotion> register_scans(const ThinScan& first, const ThinScan& second) {
  const Seeker seeker(first);
  // Where bearings grow clockwise, the mirrored plane is searched; distances are the same in it.
  const double cross =
      first.points()[0].p.x() * first.points()[1].p.y() - first.points()[0].p.y() * first.points()[1].p.x();
  const int sign = cross >= 0.0 ? 1 : -1;
  const double range = std::max(first.median_range(), second.median_range());
  Planar T;
  double best = 1e300;
  for (int k = -kSteps; k <= kSteps; ++k) {
    const double cost = misfit(seeker, second, k * kStepRad, sign, kFirstGate * range) * (1.0 + 1e-3 * std::abs(k));
    if (cost < best) {
      best = cost;
      T.yaw = k * kStepRad;
    }
  }

  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  Eigen::Matrix2d normals = Eigen::Matrix2d::Zero();
  double scale = kFirstGate * range;
  double squares = 0.0;
  double weights = 0.0;
  int inliers = 0;
  std::array<double, ThinScan::kMost + 1> sizes{};
  for (int i = 0; i < kIterations; ++i) {
    const double gate = std::max(kLastGate * range, kFirstGate * range * std::pow(0.75, i));
    H.setZero();
    normals.setZero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    squares = weights = 0.0;
    inliers = 0;
    std::size_t used = 0;
    for (const ThinScan::Point& point : second.points()) {
      const Eigen::Vector2d p = T * point.p;
      const Pair pair = closest(seeker, p, sign, gate);
      if (pair.target == nullptr) continue;
      ++inliers;
      const Eigen::Vector2d lever = p - T.t;
      const auto add = [&](const Eigen::Vector2d& direction, double share) {
        const double residual = direction.dot(pair.target->p - p);
        const double u = residual / (3.0 * scale);
        const double weight = share / (1.0 + u * u);
        const Eigen::Vector3d J(direction.x(), direction.y(), direction.y() * lever.x() - direction.x() * lever.y());
        H += weight * J * J.transpose();
        b += weight * residual * J;
        squares += weight * residual * residual;
        weights += weight;
        if (share == 1.0 && used < sizes.size()) sizes[used++] = std::abs(residual);
      };
      if (!pair.target->normal.isZero(0.0)) {
        add(pair.target->normal, 1.0);
        normals += pair.target->normal * pair.target->normal.transpose();
      } else {
        add(Eigen::Vector2d::UnitX(), 0.1);
        add(Eigen::Vector2d::UnitY(), 0.1);
      }
    }
    if (inliers < kLeastPoints / 2) return std::nullopt;
    // A corridor leaves a direction open: it then stays where it is.
    Eigen::Matrix3d damped = H;
    damped.diagonal() *= 1.0 + 1e-6;
    const Eigen::LDLT<Eigen::Matrix3d> factor(damped);
    if (factor.info() != Eigen::Success || factor.vectorD().minCoeff() <= 0.0) return std::nullopt;
    const Eigen::Vector3d step = factor.solve(b);
    if (!step.allFinite()) return std::nullopt;
    T.t += step.head<2>();
    T.yaw += step.z();
    if (used > 4) {
      const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(used / 2);
      std::nth_element(sizes.begin(), middle, sizes.begin() + static_cast<std::ptrdiff_t>(used));
      scale = std::max(1.4826 * *middle, 1e-4 * range);
    }
    if (i > 6 && step.head<2>().norm() < 1e-4 * range && std::abs(step.z()) < 1e-4 && gate <= kLastGate * range * 1.01)
      break;
  }
  ScanMotion motion;
  motion.x = T.t.x();
  motion.y = T.t.y();
  motion.yaw = T.yaw;
  const double half_trace = 0.5 * normals.trace();
  const double root = std::sqrt(std::max(0.0, half_trace * half_trace - normals.determinant()));
  motion.is_shift_known = half_trace - root > kLeastSpread * (half_trace + root);
  motion.inliers = static_cast<double>(inliers) / static_cast<double>(second.points().size());
  if (motion.inliers < kLeastInliers || weights < 20.0) return std::nullopt;
  motion.covariance = squares / weights * H.inverse();
  if (!motion.covariance.allFinite() || !(motion.covariance(2, 2) < kMostYawSigma * kMostYawSigma)) return std::nullopt;
  return motion;
}

}  // namespace waymark::host::diagnosis
