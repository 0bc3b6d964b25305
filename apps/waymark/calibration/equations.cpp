// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/calibration/equations.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "waymark/base/error.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::calibration {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kKnotSeconds = 0.05;
constexpr double kSmoothSeconds = 0.5;  // of the motion that a noise grows with: that of the reading would bias it
constexpr double kMarginSeconds = 0.5;  // at the ends, for delays that change
constexpr double kGyroSeconds = 0.1;    // of one equation
constexpr double kMinDensity = 1e-5;
constexpr double kUsualGyroDensity = 8.73e-4;  // [rad/√s]
constexpr double kBiasSigma = 0.1;             // [rad/s]
constexpr double kBiasWalk = 5e-5;             // [rad/s/√s]
constexpr double kBiasSeconds = 30.0;          // between nodes
constexpr double kAnchorSigma = 1e-3;          // of the first pose, where nothing else ties the path to the map
constexpr double kUnknownMotion = 100.0;       // σ [m, rad] over a gap of the wheels
const Eigen::Matrix2d kQuarterTurn = (Eigen::Matrix2d() << 0.0, -1.0, 1.0, 0.0).finished();

Eigen::Matrix2d rotation(double angle) { return Eigen::Rotation2Dd(angle).toRotationMatrix(); }

double number_of(const Config& yaml, const std::string& name, const char* key, double fallback) {
  for (const Config& sensor : yaml.items("sensors")) {
    if (sensor.text("name") == name) return sensor.has(key) ? sensor.number(key) : fallback;
  }
  return fallback;
}

std::size_t slow_count(double span, double step) {
  return static_cast<std::size_t>(std::ceil(std::max(span, step) / step)) + 1;
}

}  // namespace

/// The pose at a time between two knots, on the arc through both, and the smoothed velocity there.
struct Equations::PoseAt {
  Eigen::Index knot = 0;
  double share = 0.0;
  Eigen::Vector2d p;
  double yaw = 0.0;
  Eigen::Vector2d velocity;
  double rate = 0.0;
};

/// Collects rows.
struct Equations::Builder {
  const Eigen::VectorXd& x;
  const Eigen::VectorXd& reference;
  const Eigen::VectorXd& log_levels;
  std::vector<Eigen::Triplet<double>> triplets;
  std::vector<double> residuals;
  Rows rows;
  std::vector<std::pair<Eigen::Index, double>> entries;

  /// The next row belongs to another measurement.
  void measurement() { rows.of.push_back(static_cast<Eigen::Index>(residuals.size())); }
  void entry(Eigen::Index column, double derivative) {
    if (column >= 0 && derivative != 0.0) entries.emplace_back(column, derivative);
  }
  /// The derivative by the pose at a time, applied to both knots, and to a delay of its sensor.
  void pose(const PoseAt& at, const Eigen::Vector3d& gradient, Eigen::Index delay) {
    for (int i = 0; i < 3; ++i) {
      entry(3 * at.knot + i, (1.0 - at.share) * gradient(i));
      entry(3 * at.knot + 3 + i, at.share * gradient(i));
    }
    entry(delay, -gradient.head<2>().dot(at.velocity) - gradient.z() * at.rate);
  }
  void slow(const Slow& slow, double t, double derivative) {
    const auto [node, share] = place(slow, t);
    entry(node, (1.0 - share) * derivative);
    entry(node + 1, share * derivative);
  }
  double slow_value(const Slow& slow, double t) const {
    const auto [node, share] = place(slow, t);
    return (1.0 - share) * x(node) + share * x(node + 1);
  }
  static std::pair<Eigen::Index, double> place(const Slow& slow, double t) {
    const double at = std::clamp((t - slow.begin) / slow.step, 0.0, static_cast<double>(slow.count - 1));
    const auto node = std::min(static_cast<Eigen::Index>(at), slow.count - 2);
    return {slow.first + node, at - static_cast<double>(node)};
  }
  double level(int index) const { return index < 0 ? 1.0 : std::exp(log_levels(index)); }
  /// Ends a row with what was entered since the last one.
  void row(double t, double residual, double sigma, const Rows::Noise& noise) {
    const auto index = static_cast<int>(residuals.size());
    for (const auto& [column, derivative] : entries)
      triplets.emplace_back(index, static_cast<int>(column), derivative / sigma);
    entries.clear();
    residuals.push_back(residual / sigma);
    rows.noise.push_back(noise);
    rows.t.push_back(t);
  }
};

Equations::Equations(const Recording& recording, const Config& yaml, std::vector<Parameter> parameters)
    : recording_(recording), parameters_(std::move(parameters)), values_(yaml, parameters_) {
  const double begin = recording.path.front().t;
  const double end = recording.path.back().t;
  for (const double t : recording.wheels.front().speed.times()) {
    if (t >= begin && t <= end && (knots_.empty() || t - knots_.back() >= kKnotSeconds)) knots_.push_back(t);
  }
  if (knots_.size() < 3) throw Error("the wheels' log is too short for a calibration");
  first_parameter_ = 3 * static_cast<Eigen::Index>(knots_.size());
  for (std::size_t i = 0; i < parameters_.size(); ++i) {
    (parameters_[i].kind == Parameter::Kind::noise ? levels_ : columns_).push_back(static_cast<int>(i));
  }
  for (const Wheels& wheels : recording.wheels)
    wheels_given_.push_back(
        {number_of(yaml, wheels.sensor, "speed_scale", 1.0), number_of(yaml, wheels.sensor, "curvature_per_m", 0.0),
         number_of(yaml, wheels.sensor, "yaw_scale", 1.0), number_of(yaml, wheels.sensor, "track_m", 0.0)});
  for (const Positions& positions : recording.positions) {
    // A fix's own σ is larger than the level in the YAML, or that counts.
    const double given = number_of(yaml, positions.sensor, "sigma_m", 0.0);
    const auto follows = std::ranges::count_if(
        positions.fixes, [&](const Positions::Fix& fix) { return std::abs(fix.sigma - given) < 0.01 * given; });
    const bool is_key = 2 * static_cast<std::size_t>(follows) > positions.fixes.size();
    const int level = is_key ? level_of(positions.sensor, "sigma_m") : -1;
    position_levels_.push_back(level >= 0 ? level : hidden_level());
    std::array<Slow, 2> both{};
    if (positions.slow_sigma > 0.0) {
      const double step = std::max(1.0, 0.1 * positions.slow_tau_s);
      const double keeps = std::exp(-step / positions.slow_tau_s);
      const double walk = positions.slow_sigma * std::sqrt(1.0 - keeps * keeps);
      for (Slow& one : both)
        one = slow(step, positions.slow_sigma, keeps, walk, level_of(positions.sensor, "offset_sigma_m"));
    }
    offsets_.push_back(both);
  }
  for (const Headings& headings : recording.headings) {
    const double given = number_of(yaml, headings.sensor, "sigma_deg", 5.0) * kDegree;
    const bool is_key = std::abs(headings.headings.front().sigma - given) < 0.01 * given;
    const int level = is_key ? level_of(headings.sensor, "sigma_deg") : -1;
    heading_levels_.push_back(level >= 0 ? level : hidden_level());
  }
  for (std::size_t i = 0; i < recording.gyros.size(); ++i) {
    biases_.push_back(slow(kBiasSeconds, kBiasSigma, 1.0, kBiasWalk * std::sqrt(kBiasSeconds), -1));
    gyro_levels_.push_back(hidden_level());
  }
  for (std::size_t i = 0; i < recording.scanners.size(); ++i) scanner_levels_.push_back(hidden_level());
}

int Equations::hidden_level() {
  levels_.push_back(-1);
  return static_cast<int>(levels_.size()) - 1;
}

Equations::Slow Equations::slow(double step, double sigma, double keeps, double walk_sigma, int level) {
  Slow one;
  one.first = first_parameter_;
  one.count = static_cast<Eigen::Index>(slow_count(knots_.back() - knots_.front(), step));
  one.begin = knots_.front();
  one.step = step;
  one.sigma = sigma;
  one.keeps = keeps;
  one.walk_sigma = walk_sigma;
  one.level = level;
  first_parameter_ += one.count;
  return one;
}

int Equations::column_of(const std::string& sensor, std::string_view key, int element) const {
  for (std::size_t k = 0; k < columns_.size(); ++k) {
    const Parameter& one = parameters_[static_cast<std::size_t>(columns_[k])];
    if (one.sensor == sensor && one.key == key && one.element == element)
      return static_cast<int>(first_parameter_) + static_cast<int>(k);
  }
  return -1;
}

int Equations::level_of(const std::string& sensor, std::string_view key, int element) const {
  for (std::size_t k = 0; k < levels_.size(); ++k) {
    if (levels_[k] < 0) continue;
    const Parameter& one = parameters_[static_cast<std::size_t>(levels_[k])];
    if (one.sensor == sensor && one.key == key && (element < 0 || one.element == element)) return static_cast<int>(k);
  }
  return -1;
}

/// A place of the list under the key of a level, as given.
double Equations::density(int level, std::size_t place) const {
  if (level < 0) return 0.0;
  const std::vector<double> list = values_.given(static_cast<std::size_t>(levels_[static_cast<std::size_t>(level)]));
  return place < list.size() ? list[place] : 0.0;
}

Eigen::VectorXd Equations::start() const {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(size());
  const std::vector<PathPoint>& path = recording_.path;
  std::size_t at = 0;
  for (std::size_t k = 0; k < knots_.size(); ++k) {
    while (at + 2 < path.size() && path[at + 1].t < knots_[k]) ++at;
    const double span = path[at + 1].t - path[at].t;
    const double share = span > 0.0 ? std::clamp((knots_[k] - path[at].t) / span, 0.0, 1.0) : 0.0;
    x.segment<3>(3 * static_cast<Eigen::Index>(k)) = (1.0 - share) * path[at].pose + share * path[at + 1].pose;
  }
  return x;
}

bool Equations::is_within(double t) const {
  return t >= knots_.front() + kMarginSeconds && t <= knots_.back() - kMarginSeconds;
}

/// Without velocities.
Equations::PoseAt Equations::on_path(const Eigen::VectorXd& x, double t) const {
  const auto next = std::upper_bound(knots_.begin(), knots_.end(), t);
  const auto k =
      std::clamp(next - knots_.begin() - 1, std::ptrdiff_t{0}, static_cast<std::ptrdiff_t>(knots_.size()) - 2);
  PoseAt at;
  at.knot = k;
  const double span = knots_[static_cast<std::size_t>(k) + 1] - knots_[static_cast<std::size_t>(k)];
  at.share = (t - knots_[static_cast<std::size_t>(k)]) / span;
  const Eigen::Vector2d p0 = x.segment<2>(3 * k);
  const Eigen::Vector2d chord = x.segment<2>(3 * k + 3) - p0;
  const double turn = x(3 * k + 5) - x(3 * k + 2);
  at.p = p0 + at.share * chord - 0.5 * at.share * (1.0 - at.share) * turn * (kQuarterTurn * chord);
  at.yaw = x(3 * k + 2) + at.share * turn;
  return at;
}

/// The wheels' noise is in the path, so the path's own velocity from knot to knot is correlated with its error, and a
/// delay found with it would be wrong. Means over a time that lies symmetrically about t are not: instruments.
Equations::PoseAt Equations::pose_at(const Builder& out, double t, int delay) const {
  const double reference = delay < 0 ? 0.0 : out.reference(delay);
  const double beyond = delay < 0 ? 0.0 : out.x(delay) - reference;
  const PoseAt before = on_path(out.reference, t - reference - 0.5 * kSmoothSeconds);
  const PoseAt after = on_path(out.reference, t - reference + 0.5 * kSmoothSeconds);
  const Eigen::Vector2d velocity = (after.p - before.p) / kSmoothSeconds;
  const double rate = (after.yaw - before.yaw) / kSmoothSeconds;
  PoseAt at = on_path(out.x, t - reference);
  at.velocity = velocity;
  at.rate = rate;
  at.p -= beyond * velocity;
  at.yaw -= beyond * rate;
  return at;
}

void Equations::add_wheels(const Wheels& wheels, std::size_t index, Builder& out) const {
  const WheelsGiven& given = wheels_given_[index];
  const int scale_column = column_of(wheels.sensor, "speed_scale");
  const int curvature_column = column_of(wheels.sensor, "curvature_per_m");
  const int length_column = std::max(column_of(wheels.sensor, "track_m"), column_of(wheels.sensor, "wheelbase_m"));
  const int yaw_scale_column = column_of(wheels.sensor, "yaw_scale");
  const auto value = [&](int column) { return column < 0 ? 0.0 : out.x(column); };
  const double scale = 1.0 + value(scale_column) / given.speed_scale;  // of what the YAML gives
  const double yaw_scale = (1.0 + value(yaw_scale_column) / given.yaw_scale) * std::exp(-value(length_column));
  const double rotation_scale = (wheels.yaw_scales_with_speed ? scale : 1.0) * yaw_scale;
  const double curvature = given.curvature + value(curvature_column);

  const int speed_level = level_of(wheels.sensor, "speed_noise_m_per_sqrt_s");
  const int lateral_level = level_of(wheels.sensor, "lateral_noise_m_per_sqrt_s");
  const int yaw_level = level_of(wheels.sensor, "yaw_noise_rad_per_sqrt_s", 0);
  const int turn_level = level_of(wheels.sensor, "yaw_noise_rad_per_sqrt_s", 2);
  const auto density_of = [&](int level, double speed) {
    return out.level(level) * (density(level, 0) + density(level, 1) * std::abs(speed));
  };

  for (std::size_t k = 0; k + 1 < knots_.size(); ++k) {
    const double a = knots_[k];
    const double b = knots_[k + 1];
    const double span = b - a;
    const double middle = 0.5 * (a + b);
    const auto at = static_cast<Eigen::Index>(3 * k);
    const double turn = out.x(at + 5) - out.x(at + 2);
    const Eigen::Vector2d chord = out.x.segment<2>(at + 3) - out.x.segment<2>(at);
    const Eigen::Matrix2d R = rotation(out.x(at + 2) + 0.5 * turn).transpose();
    const Eigen::Vector2d v = R * chord * ((1.0 + turn * turn / 24.0) / span);
    const std::optional<double> speed = wheels.speed.mean(a, b);
    const std::optional<double> lateral = wheels.lateral.mean(a, b);
    const std::optional<double> rate = wheels.rate.mean(a, b);
    const auto enter_speed = [&](int axis, double factor) {
      for (int i = 0; i < 2; ++i) {
        out.entry(at + i, -factor * R(axis, i) / span);
        out.entry(at + 3 + i, factor * R(axis, i) / span);
      }
      const double by_heading = 0.5 * factor * (axis == 0 ? v.y() : -v.x());
      out.entry(at + 2, by_heading);
      out.entry(at + 5, by_heading);
    };
    if (!speed || !lateral) {
      // The first sensor's stamps are the knots: over a gap nothing else ties two of them together.
      if (index != 0) continue;
      for (int i = 0; i < 3; ++i) {
        out.measurement();
        out.entry(at + i, -1.0);
        out.entry(at + 3 + i, 1.0);
        out.row(std::numeric_limits<double>::quiet_NaN(), out.x(at + 3 + i) - out.x(at + i), kUnknownMotion, {});
      }
      continue;
    }
    const double smooth_speed =
        wheels.speed.mean(middle - 0.5 * kSmoothSeconds, middle + 0.5 * kSmoothSeconds).value_or(*speed);
    const double smooth_rate =
        wheels.rate.mean(middle - 0.5 * kSmoothSeconds, middle + 0.5 * kSmoothSeconds).value_or(rate.value_or(0.0));
    const double per_span = 1.0 / std::sqrt(span);

    // Two wheels of unequal size also move the robot forward while it turns: (b − a)/4 · (right − left), with the
    // wheels' scales a and b, whose difference is the curvature times the track.
    const double raw_speed = *speed / given.speed_scale;
    const double raw_rate = rate ? *rate - given.curvature * raw_speed : 0.0;
    const double by_unequal = 0.25 * given.track * given.track * std::exp(value(length_column)) * raw_rate;
    const double forward = v.x() - curvature * by_unequal;
    out.measurement();
    enter_speed(0, 1.0 / scale);
    out.entry(scale_column, -forward / (scale * scale * given.speed_scale));
    out.entry(curvature_column, -by_unequal / scale);
    out.entry(length_column, -curvature * by_unequal / scale);
    out.row(middle, forward / scale - *speed, std::max(kMinDensity, density_of(speed_level, smooth_speed)) * per_span,
            {{speed_level, -1}, {2.0, 0.0}});

    out.measurement();
    enter_speed(1, 1.0 / scale);
    out.entry(scale_column, -v.y() / (scale * scale * given.speed_scale));
    out.row(middle, v.y() / scale - *lateral, std::max(kMinDensity, density_of(lateral_level, smooth_speed)) * per_span,
            {{lateral_level, -1}, {2.0, 0.0}});

    if (!rate) continue;
    // rate = rotation_scale · (what the wheels say without the curvature) + curvature · speed without scale
    const double turned = (turn / span - curvature * raw_speed) / rotation_scale;
    out.measurement();
    out.entry(at + 2, -1.0 / (span * rotation_scale));
    out.entry(at + 5, 1.0 / (span * rotation_scale));
    out.entry(curvature_column, -raw_speed / rotation_scale);
    if (wheels.yaw_scales_with_speed) out.entry(scale_column, -turned / (scale * given.speed_scale));
    out.entry(length_column, turned);
    out.entry(yaw_scale_column, -turned / (given.yaw_scale + value(yaw_scale_column)));
    const double steady = density_of(yaw_level, smooth_speed);
    const double turning =
        turn_level < 0 ? 0.0 : out.level(turn_level) * density(turn_level, 0) * std::abs(smooth_rate);
    const double all = std::max(kMinDensity, steady + turning);
    out.row(middle, turned - raw_rate, all * per_span,
            {{yaw_level, turn_level}, {2.0 * steady / all, 2.0 * turning / all}});
  }
}

void Equations::add_gyro(const Gyro& gyro, std::size_t index, Builder& out) const {
  const int delay = column_of(gyro.sensor, "delay_s");
  const int level = gyro_levels_[index];
  const std::vector<double>& times = gyro.rate.times();
  std::size_t from = 0;
  for (std::size_t to = 1; to < times.size(); ++to) {
    const double span = times[to] - times[from];
    if (span < kGyroSeconds) continue;
    const double a = times[from];
    const double b = times[to];
    from = to;
    const std::optional<double> rate = gyro.rate.mean(a, b);
    if (!rate || !is_within(a) || !is_within(b)) continue;
    const PoseAt first = pose_at(out, a, delay);
    const PoseAt last = pose_at(out, b, delay);
    out.measurement();
    out.pose(first, Eigen::Vector3d(0.0, 0.0, -1.0 / span), delay);
    out.pose(last, Eigen::Vector3d(0.0, 0.0, 1.0 / span), delay);
    out.slow(biases_[index], a, 1.0);
    const double residual = (last.yaw - first.yaw) / span + out.slow_value(biases_[index], a) - *rate;
    out.row(a, residual, kUsualGyroDensity * out.level(level) / std::sqrt(span), {{level, -1}, {2.0, 0.0}});
  }
}

void Equations::add_positions(const Positions& positions, std::size_t index, Builder& out) const {
  const int delay = column_of(positions.sensor, "delay_s");
  const std::array<int, 2> arm{column_of(positions.sensor, "base_p_antenna_m", 0),
                               column_of(positions.sensor, "base_p_antenna_m", 1)};
  Eigen::Vector2d lever = positions.lever;
  for (int i = 0; i < 2; ++i) {
    if (arm[static_cast<std::size_t>(i)] >= 0) lever(i) += out.x(arm[static_cast<std::size_t>(i)]);
  }
  const int level = position_levels_[index];
  const double factor = out.level(level);
  for (const Positions::Fix& fix : positions.fixes) {
    if (!is_within(fix.t)) continue;
    const PoseAt at = pose_at(out, fix.t, delay);
    const Eigen::Matrix2d R = rotation(at.yaw);
    const Eigen::Vector2d expected = at.p + R * lever;
    const Eigen::Vector2d by_yaw = kQuarterTurn * (R * lever);
    out.measurement();
    for (int axis = 0; axis < 2; ++axis) {
      Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
      gradient(axis) = 1.0;
      gradient.z() = by_yaw(axis);
      out.pose(at, gradient, delay);
      for (int i = 0; i < 2; ++i) out.entry(arm[static_cast<std::size_t>(i)], R(axis, i));
      double residual = expected(axis) - fix.p(axis);
      const Slow& offset = offsets_[index][static_cast<std::size_t>(axis)];
      if (offset.count > 0) {
        residual += out.slow_value(offset, fix.t);
        out.slow(offset, fix.t, 1.0);
      }
      out.row(fix.t, residual, factor * fix.sigma, {{level, -1}, {2.0, 0.0}});
    }
  }
}

void Equations::add_headings(const Headings& headings, std::size_t index, Builder& out) const {
  const int delay = column_of(headings.sensor, "delay_s");
  const int mounting = column_of(headings.sensor, "base_T_sensor.yaw_deg");
  const double turned = mounting < 0 ? 0.0 : kDegree * out.x(mounting);
  const int level = heading_levels_[index];
  for (const Headings::One& one : headings.headings) {
    if (!is_within(one.t)) continue;
    const PoseAt at = pose_at(out, one.t, delay);
    out.measurement();
    out.pose(at, Eigen::Vector3d::UnitZ(), delay);
    out.entry(mounting, kDegree);
    out.row(one.t, so3::wrap(at.yaw - one.yaw + turned), out.level(level) * one.sigma, {{level, -1}, {2.0, 0.0}});
  }
}

void Equations::add_scanner(const Scanner& scanner, std::size_t index, Builder& out) const {
  const int delay = column_of(scanner.sensor, "delay_s");
  const int mounting = column_of(scanner.sensor, "base_T_sensor.yaw_deg");
  const std::array<int, 2> place{column_of(scanner.sensor, "base_T_sensor.xyz_m", 0),
                                 column_of(scanner.sensor, "base_T_sensor.xyz_m", 1)};
  const double turned = mounting < 0 ? 0.0 : kDegree * out.x(mounting);
  Eigen::Vector2d lever = scanner.lever;
  for (int i = 0; i < 2; ++i) {
    if (place[static_cast<std::size_t>(i)] >= 0) lever(i) += out.x(place[static_cast<std::size_t>(i)]);
  }
  const int level = scanner_levels_[index];
  for (const Scanner::Motion& one : scanner.motions) {
    if (!is_within(one.from) || !is_within(one.to)) continue;
    const PoseAt first = pose_at(out, one.from, delay);
    const PoseAt last = pose_at(out, one.to, delay);
    // The motion of the scanner in the axes of the base at the first scan: hand-eye equations in the plane.
    const double turn = last.yaw - first.yaw;
    const Eigen::Matrix2d to_axes = rotation(-turned - first.yaw);
    const Eigen::Matrix2d arm = rotation(-turned) * (rotation(turn) - Eigen::Matrix2d::Identity());
    const Eigen::Vector2d shift = to_axes * (last.p - first.p) + arm * lever;
    Eigen::Vector3d residual;
    residual << shift - one.moved.head<2>(), so3::wrap(turn - one.moved.z());
    const Eigen::Vector2d by_turn = rotation(-turned + turn) * (kQuarterTurn * lever);
    Eigen::Matrix3d by_last = Eigen::Matrix3d::Zero();
    by_last.topLeftCorner<2, 2>() = to_axes;
    by_last.topRightCorner<2, 1>() = by_turn;
    by_last(2, 2) = 1.0;
    Eigen::Matrix3d by_first = -by_last;
    by_first.topRightCorner<2, 1>() = -by_turn - to_axes * (kQuarterTurn * (last.p - first.p));
    Eigen::Vector3d by_mounting = Eigen::Vector3d::Zero();
    by_mounting.head<2>() = -kDegree * (kQuarterTurn * shift);
    const Eigen::LLT<Eigen::Matrix3d> L(one.covariance);
    if (L.info() != Eigen::Success) continue;
    residual = L.matrixL().solve(residual);
    by_first = L.matrixL().solve(by_first);
    by_last = L.matrixL().solve(by_last);
    by_mounting = L.matrixL().solve(by_mounting);
    Eigen::Matrix<double, 3, 2> by_place = Eigen::Matrix<double, 3, 2>::Zero();
    by_place.topRows<2>() = arm;
    by_place = L.matrixL().solve(by_place);
    out.measurement();
    for (int r = 0; r < 3; ++r) {
      out.pose(first, by_first.row(r), delay);
      out.pose(last, by_last.row(r), delay);
      out.entry(mounting, by_mounting(r));
      for (int i = 0; i < 2; ++i) out.entry(place[static_cast<std::size_t>(i)], by_place(r, i));
      out.row(one.from, residual(r), out.level(level), {{level, -1}, {2.0, 0.0}});
    }
  }
}

void Equations::add_slow(const Slow& slow, Builder& out) const {
  const double factor = out.level(slow.level);
  const Rows::Noise noise{{slow.level, -1}, {slow.level < 0 ? 0.0 : 2.0, 0.0}};
  const double prior = std::numeric_limits<double>::quiet_NaN();
  for (Eigen::Index k = 0; k < slow.count; ++k) {
    out.measurement();
    out.entry(slow.first + k, 1.0);
    if (k > 0) out.entry(slow.first + k - 1, -slow.keeps);
    const double before = k == 0 ? 0.0 : slow.keeps * out.x(slow.first + k - 1);
    out.row(prior, out.x(slow.first + k) - before, factor * (k == 0 ? slow.sigma : slow.walk_sigma), noise);
  }
}

void Equations::add_priors(Builder& out) const {
  const double prior = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t k = 0; k < columns_.size(); ++k) {
    const Eigen::Index column = first_parameter_ + static_cast<Eigen::Index>(k);
    out.measurement();
    out.entry(column, 1.0);
    out.row(prior, out.x(column), parameters_[static_cast<std::size_t>(columns_[k])].prior_sigma, {});
  }
  for (int i = 0; i < 3; ++i) {
    const bool is_tied = !recording_.positions.empty() || (i == 2 && !recording_.headings.empty());
    if (is_tied) continue;
    out.measurement();
    out.entry(i, 1.0);
    out.row(prior, out.x(i) - recording_.path.front().pose(i), kAnchorSigma, {});
  }
}

Rows Equations::linearize(const Eigen::VectorXd& x, const Eigen::VectorXd& reference,
                          const Eigen::VectorXd& log_levels) const {
  Builder out{x, reference, log_levels, {}, {}, {}, {}};
  for (std::size_t i = 0; i < recording_.wheels.size(); ++i) add_wheels(recording_.wheels[i], i, out);
  for (std::size_t i = 0; i < recording_.gyros.size(); ++i) {
    add_gyro(recording_.gyros[i], i, out);
    add_slow(biases_[i], out);
  }
  for (std::size_t i = 0; i < recording_.positions.size(); ++i) {
    add_positions(recording_.positions[i], i, out);
    for (const Slow& one : offsets_[i]) add_slow(one, out);
  }
  for (std::size_t i = 0; i < recording_.headings.size(); ++i) add_headings(recording_.headings[i], i, out);
  for (std::size_t i = 0; i < recording_.scanners.size(); ++i) add_scanner(recording_.scanners[i], i, out);
  add_priors(out);
  const auto count = static_cast<Eigen::Index>(out.residuals.size());
  out.rows.of.push_back(count);
  out.rows.e = Eigen::Map<const Eigen::VectorXd>(out.residuals.data(), count);
  out.rows.J.resize(count, size());
  out.rows.J.setFromTriplets(out.triplets.begin(), out.triplets.end());
  return std::move(out.rows);
}

}  // namespace waymark::calibration
