// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/calibration/equations.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "apps/waymark/calibration/equation_builder.hpp"
#include "waymark/base/error.hpp"

namespace waymark::calibration {

namespace {

constexpr double kKnotSeconds = 0.05;
constexpr double kMarginSeconds = 0.5;  // at the ends, for delays that change
constexpr double kSmoothSeconds = 0.5;  // of the path's velocity
constexpr double kBiasSigma = 0.1;      // [rad/s]
constexpr double kBiasWalk = 5e-5;      // [rad/s/√s]
constexpr double kBiasSeconds = 30.0;   // between nodes
constexpr double kAnchorSigma = 1e-3;   // of the first pose, where nothing else ties the path to the map

std::size_t slow_count(double span, double step) {
  return static_cast<std::size_t>(std::ceil(std::max(span, step) / step)) + 1;
}

}  // namespace

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
  path_is_measured_ = path_is_measured();
}

/// Where positions wander faster than wheels err, the path would follow them, and the noise of the wheels would be
/// theirs.
bool Equations::path_is_measured() const {
  if (!recording_.scanners.empty()) return true;
  const Wheels& wheels = recording_.wheels.front();
  const Density given = density_of(wheels.sensor, "speed_noise_m_per_sqrt_s");
  const double speed = std::abs(wheels.speed.mean(knots_.front(), knots_.back()).value_or(1.0));
  const double noise = given.fixed + given.growing * speed;
  return std::ranges::any_of(recording_.positions, [&](const Positions& positions) {
    const double wander =
        positions.slow_sigma > 0.0 ? positions.slow_sigma * std::sqrt(2.0 / positions.slow_tau_s) : 0.0;
    return wander < noise;
  });
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

Equations::Density Equations::density_of(const std::string& sensor, std::string_view key, int element) const {
  const int level = level_of(sensor, key, element);
  if (level < 0) return {};
  const std::vector<double> list = values_.given(static_cast<std::size_t>(levels_[static_cast<std::size_t>(level)]));
  return {level, list.empty() ? 0.0 : list[0], list.size() < 2 ? 0.0 : list[1]};
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
