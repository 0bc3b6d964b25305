// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "apps/waymark/calibration/parameter.hpp"
#include "apps/waymark/calibration/recording.hpp"

namespace waymark::calibration {

/// The equations of an adjustment, linearised and divided by their σ.
struct Rows {
  /// How the logarithm of a row's variance depends on the logarithms of two levels of noise; -1: none.
  struct Noise {
    std::array<int, 2> level{-1, -1};
    std::array<double, 2> slope{0.0, 0.0};
  };
  Eigen::SparseMatrix<double, Eigen::RowMajor> J;
  Eigen::VectorXd e;             ///< residual / σ
  std::vector<Noise> noise;      ///< of each row
  std::vector<double> t;         ///< of each row [s]; NaN: a prior
  std::vector<Eigen::Index> of;  ///< first row of each measurement, and the number of rows: its rows are one outlier
};

/// What a recording says, as a least-squares problem in which the path of the robot is unknown, too: poses at the
/// wheels' stamps (not closer than 50 ms), slow errors of positions and gyros, and parameters of the YAML. The readings
/// of the wheels are measurements of the motion from pose to pose, so their noise is in the residuals and not in the
/// regressors (errors in variables).
///
/// The unknowns are x = (poses, slow errors, parameters that are no levels of noise); the levels are apart.
class Equations {
 public:
  /// `parameters`: what is estimated; all levels of noise that the sensors have should be among them. `recording` must
  /// outlive this. Throws Error if the log is too short.
  Equations(const Recording& recording, const Config& yaml, std::vector<Parameter> parameters);

  Eigen::Index size() const { return first_parameter_ + static_cast<Eigen::Index>(columns_.size()); }
  Eigen::Index first_parameter() const { return first_parameter_; }
  /// Indices of the parameters that are unknowns, in order, and of those that are levels of noise; a level without a
  /// key in the YAML has -1.
  const std::vector<int>& columns() const { return columns_; }
  const std::vector<int>& levels() const { return levels_; }
  /// The covariance of a registration is the least that a motion of scans can have: the level of a scanner is at least
  /// 0.
  bool is_bounded(Eigen::Index level) const {
    return std::ranges::find(scanner_levels_, static_cast<int>(level)) != scanner_levels_.end();
  }
  const std::vector<Parameter>& parameters() const { return parameters_; }

  /// Of the poses [s].
  const std::vector<double>& times() const { return knots_; }

  /// The filter's path, no slow errors, the parameters as the YAML gives them.
  Eigen::VectorXd start() const;
  /// The equations at x, with levels of noise exp(log_levels) times what the YAML gives. Delays count linearly from
  /// those of `reference` on, with the velocities of its path.
  Rows linearize(const Eigen::VectorXd& x, const Eigen::VectorXd& reference, const Eigen::VectorXd& log_levels) const;

 private:
  /// A slow error, linear between nodes.
  struct Slow {
    Eigen::Index first = 0;
    Eigen::Index count = 0;
    double begin = 0.0;
    double step = 1.0;
    double sigma = 0.0;       ///< of the first node
    double keeps = 1.0;       ///< of one node's value at the next one
    double walk_sigma = 0.0;  ///< of what comes in addition
    int level = -1;           ///< of its noise
  };
  /// A noise as the YAML gives it, fixed + growing · motion, and the level that scales it; −1: there is none.
  struct Density {
    int level = -1;
    double fixed = 0.0;
    double growing = 0.0;
  };
  struct Builder;
  struct PoseAt;
  struct WheelModel;
  /// Means from one pose to the next.
  struct WheelStep {
    double speed;
    double lateral;
    std::optional<double> rate;
  };

  int column_of(const std::string& sensor, std::string_view key, int element = -1) const;
  int level_of(const std::string& sensor, std::string_view key, int element = -1) const;
  Density density_of(const std::string& sensor, std::string_view key, int element = -1) const;
  int hidden_level();
  Slow slow(double step, double sigma, double keeps, double walk_sigma, int level);
  WheelModel model_of(const Wheels& wheels, std::size_t index, const Builder& out) const;
  void add_gap(std::size_t knot, Builder& out) const;
  void add_step(const Wheels& wheels, const WheelModel& model, std::size_t knot, const WheelStep& step,
                Builder& out) const;
  void add_wheels(const Wheels& wheels, std::size_t index, Builder& out) const;
  bool path_is_measured() const;
  void add_gyro(const Gyro& gyro, std::size_t index, Builder& out) const;
  void add_positions(const Positions& positions, std::size_t index, Builder& out) const;
  void add_headings(const Headings& headings, std::size_t index, Builder& out) const;
  void add_scanner(const Scanner& scanner, std::size_t index, Builder& out) const;
  void add_slow(const Slow& slow, Builder& out) const;
  void add_priors(Builder& out) const;
  PoseAt on_path(const Eigen::VectorXd& x, double t) const;
  PoseAt pose_at(const Builder& out, double t, int delay) const;
  bool is_within(double t) const;

  const Recording& recording_;
  std::vector<Parameter> parameters_;
  Values values_;
  std::vector<double> knots_;  // times of the poses [s]
  Eigen::Index first_parameter_ = 0;
  std::vector<int> columns_;
  std::vector<int> levels_;
  struct WheelsGiven {
    double speed_scale;
    double curvature;
    double yaw_scale;
    double track;  ///< 0: it has none
  };
  std::vector<WheelsGiven> wheels_given_;
  bool path_is_measured_ = false;  // more precisely than the wheels' noise: only then can their noise be found
  std::vector<std::array<Slow, 2>> offsets_;  // of the positions
  std::vector<int> position_levels_;
  std::vector<int> heading_levels_;
  std::vector<Slow> biases_;  // of the gyros
  std::vector<int> gyro_levels_;
  std::vector<int> scanner_levels_;
};

}  // namespace waymark::calibration
