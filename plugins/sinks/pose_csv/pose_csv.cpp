// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <GeographicLib/LocalCartesian.hpp>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "waymark/io/csv_field.hpp"
#include "waymark/io/output_file.hpp"
#include "waymark/plugin/sink.hpp"

namespace waymark::pose_csv {
namespace {

constexpr std::string_view kHeader =
    "t_s,x_m,y_m,z_m,latitude_deg,longitude_deg,height_m,roll_rad,pitch_rad,yaw_rad,v_x_mps,v_y_mps,v_z_mps,w_x_radps,"
    "w_y_radps,w_z_radps,sigma_x_m,sigma_y_m,sigma_z_m,sigma_roll_rad,sigma_pitch_rad,sigma_yaw_rad\n";

constexpr int kDecimals = 6;
constexpr int kDegreeDecimals = 10;  // 0.01 mm
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

bool was_taken_in(Fate fate) {
  return fate == Fate::fused || fate == Fate::gated || fate == Fate::mapped || fate == Fate::skipped ||
         fate == Fate::held_out;
}

/// Covariance of position and attitude error (map frame); zero where planar motion holds a state fixed.
Matrix6d pose_errors(const Belief& belief, const StateLayout& layout) {
  Matrix6d P = Matrix6d::Zero();
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) {
      const int i = layout.active(row);
      const int j = layout.active(column);
      if (i >= 0 && j >= 0) P(row, column) = belief.P(i, j);
    }
  }
  return P;
}

/// d(roll, pitch, yaw) of a small rotation of the base about the map's axes.
Eigen::Matrix3d rpy_of_rotation(double pitch, double yaw) {
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  const double t = std::tan(pitch);
  Eigen::Matrix3d J;
  J << c / std::cos(pitch), s / std::cos(pitch), 0.0, -s, c, 0.0, c * t, s * t, 1.0;
  return J;
}

/// σ of x, y, z, roll, pitch, yaw; NaN where the motion is planar, and of the angles near a pitch of 90 degrees, where
/// roll and yaw are not defined.
Vector6d sigmas(const Belief& belief, const StateLayout& layout) {
  Matrix6d P = pose_errors(belief, layout);
  const Eigen::Vector3d rpy = so3::to_rpy(belief.mean.T_map_base.q);
  const bool is_planar = layout.motion() == StateLayout::Motion::planar;
  const Eigen::Matrix3d J = is_planar ? Eigen::Matrix3d::Identity().eval() : rpy_of_rotation(rpy.y(), rpy.z());
  P.bottomRightCorner<3, 3>() = (J * P.bottomRightCorner<3, 3>() * J.transpose()).eval();
  // Rounding may leave a variance a hair below zero.
  Vector6d sigma = P.diagonal().cwiseMax(0.0).cwiseSqrt();
  for (int i = 0; i < 6; ++i) {
    if (layout.active(i) < 0) sigma[i] = kUnknown;
  }
  constexpr double kLeastCosine = 0.02;
  if (!is_planar && std::cos(rpy.y()) < kLeastCosine) sigma.tail<3>().setConstant(kUnknown);
  return sigma;
}

/// The pose with place on the Earth, velocity and all σ, after every measurement.
class PoseCsv : public Sink {
 public:
  explicit PoseCsv(const Config& config)
      : name_(config.output({"file", "file name in the output folder"}, "poses.csv")),
        every_(from_seconds(config.non_negative(
            {"every_s", "s", "time between two rows; 0: a row after every measurement that was fused"}, 0.0))) {}

  void start(const RunInfo& info) override {
    file_.emplace(info.out_dir / name_);
    file_->write(kHeader);
  }

  void write(const Snapshot& snapshot) override {
    if (!snapshot.started() || !was_taken_in(snapshot.fate())) return;
    if (last_ && snapshot.stamp() - *last_ < every_) return;
    last_ = snapshot.stamp();
    file_->write(row(snapshot));
  }

  void finish(const Snapshot*, const RunReport&) override { file_->commit(); }

 private:
  std::string row(const Snapshot& snapshot) {
    const NavState& mean = snapshot.belief().mean;
    std::string text = format_time(snapshot.stamp());
    const auto add = [&](const Eigen::Ref<const Eigen::VectorXd>& values) {
      for (const double value : values) text += ',' + csv_field(value, kDecimals);
    };
    add(mean.T_map_base.p);
    const std::array<double, 3> place = place_on_earth(mean.T_map_base.p, snapshot.datum());
    text += fmt::format(",{},{},{}", csv_field(place[0], kDegreeDecimals), csv_field(place[1], kDegreeDecimals),
                        csv_field(place[2], kDecimals));
    add(so3::to_rpy(mean.T_map_base.q));
    add(mean.v_base);
    add(mean.w_base);
    add(sigmas(snapshot.belief(), snapshot.layout()));
    return text + '\n';
  }

  /// Latitude, longitude [deg], height [m]; NaN without a datum.
  std::array<double, 3> place_on_earth(const Eigen::Vector3d& p, const std::optional<Datum>& datum) {
    std::array<double, 3> place{kUnknown, kUnknown, kUnknown};
    if (!datum) return place;
    if (!has_frame_) {  // a datum never changes
      frame_.Reset(datum->latitude_deg, datum->longitude_deg, datum->height_m);
      has_frame_ = true;
    }
    frame_.Reverse(p.x(), p.y(), p.z(), place[0], place[1], place[2]);
    return place;
  }

  std::string name_;
  Duration every_;
  std::optional<Time> last_;
  std::optional<OutputFile> file_;  // open from start() to finish()
  GeographicLib::LocalCartesian frame_;
  bool has_frame_ = false;
};

}  // namespace
}  // namespace waymark::pose_csv

WAYMARK_PLUGIN(waymark::Sink, waymark::pose_csv::PoseCsv, "pose_csv", "1.0.0")
