// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "waymark/io/output_file.hpp"
#include "waymark/plugin/sink.hpp"

namespace waymark::tum {
namespace {

constexpr std::string_view kHeader =
    "# map frame (east north up), pose of base_link; timestamp_s x_m y_m z_m qx qy qz qw\n";

constexpr std::string_view kCovarianceHeader = "t_s,xx,xy,xyaw,yy,yyaw,yawyaw\n";

std::string line(Time stamp, const Eigen::Matrix3d& P) {
  return fmt::format("{},{:.6e},{:.6e},{:.6e},{:.6e},{:.6e},{:.6e}\n", format_time(stamp), P(0, 0), P(0, 1), P(0, 2),
                     P(1, 1), P(1, 2), P(2, 2));
}

// Spatial motion: z, and the rotations about x and y, each with those before it and itself.
constexpr std::string_view kSpatialHeader =
    "t_s,xx,xy,xyaw,yy,yyaw,yawyaw,xz,yz,yawz,zz,xrx,yrx,yawrx,zrx,rxrx,xry,yry,yawry,zry,rxry,ryry\n";

std::string line(Time stamp, const SpatialMatrix& P) {
  constexpr std::array<int, 3> kPlanar{0, 1, 5};
  constexpr std::array<int, 6> kOrder{0, 1, 5, 2, 3, 4};
  std::string text = line(stamp, Eigen::Matrix3d(P(kPlanar, kPlanar)));
  text.pop_back();
  for (std::size_t i = 3; i < kOrder.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) fmt::format_to(std::back_inserter(text), ",{:.6e}", P(kOrder[j], kOrder[i]));
  }
  text += '\n';
  return text;
}

std::string line(Time stamp, const Pose& pose) {
  // q and -q are the same rotation: one sign, so that equal poses give equal text.
  const Eigen::Vector4d q = pose.q.w() < 0.0 ? Eigen::Vector4d(-pose.q.coeffs()) : Eigen::Vector4d(pose.q.coeffs());
  return fmt::format("{} {:.6f} {:.6f} {:.6f} {:.9f} {:.9f} {:.9f} {:.9f}\n", format_time(stamp), pose.p.x(),
                     pose.p.y(), pose.p.z(), q.x(), q.y(), q.z(), q.w());
}

bool was_taken_in(Fate fate) {
  return fate == Fate::fused || fate == Fate::gated || fate == Fate::mapped || fate == Fate::skipped ||
         fate == Fate::held_out;
}

/// Trajectories as text, in the format of the TUM RGB-D benchmark.
class Tum : public Sink {
 public:
  explicit Tum(const Config& config)
      : trajectory_name_(
            config.output({"trajectory", "file name of the online estimate in the output folder"}, "trajectory.txt")),
        path_name_(config.output({"path", "file name of the best particle's path in the output folder"}, "path.txt")),
        reference_name_(
            config.output({"reference", "file name of the source's reference in the output folder"}, "reference.txt")),
        covariance_name_(config.output(
            {"covariance", "file name of the covariance of (x, y, yaw) in the output folder"}, "covariance.csv")) {}

  void start(const RunInfo& info) override {
    out_dir_ = info.out_dir;
    trajectory_.emplace(out_dir_ / trajectory_name_);
    trajectory_->write(kHeader);
    covariance_.emplace(out_dir_ / covariance_name_);
    if (info.reference && !info.reference->trajectory.empty()) reference_ = info.reference;
  }

  void write(const Snapshot& snapshot) override {
    if (!snapshot.started() || !was_taken_in(snapshot.fate())) return;
    trajectory_->write(line(snapshot.stamp(), snapshot.belief().mean.T_map_base));
    // With maps the covariance is shown where it means most: of the refined mixture, before a mapping step samples.
    if (snapshot.mapping_steps() > 0 && snapshot.fate() != Fate::mapped) return;
    const bool is_spatial = snapshot.layout().motion() == StateLayout::Motion::spatial;
    if (reference_) write_reference(is_spatial);
    begin_covariance(is_spatial ? kSpatialHeader : kCovarianceHeader);
    covariance_->write(is_spatial ? line(snapshot.stamp(), spatial_covariance(snapshot.belief()))
                                  : line(snapshot.stamp(), pose_covariance(snapshot.belief(), snapshot.layout())));
  }

  void finish(const Snapshot* last, const RunReport& report) override {
    trajectory_->commit();
    if (reference_) write_reference(false);
    begin_covariance(kCovarianceHeader);
    covariance_->commit();
    std::string text(kHeader);
    if (last != nullptr && last->started()) {
      for (const StampedPose& pose : last->best_path()) text += line(pose.stamp, pose.T_map_base);
    }
    write_file(out_dir_ / path_name_, text);
    if (!report.smoothed.empty()) write_smoothed(report.smoothed);
  }

 private:
  /// The motion is known at the first snapshot.
  void begin_covariance(std::string_view header) {
    if (has_covariance_header_) return;
    covariance_->write(header);
    has_covariance_header_ = true;
  }

  void write_smoothed(const std::vector<SmoothedPose>& poses) const {
    std::string text(kHeader);
    std::string covariance(kCovarianceHeader);
    for (const SmoothedPose& pose : poses) {
      text += line(pose.stamp, pose.T_map_base);
      covariance += line(pose.stamp, pose.P);
    }
    write_file(out_dir_ / "smoothed.txt", text);
    write_file(out_dir_ / "smoothed_covariance.csv", covariance);
  }

  /// Once. The height of a robot that moves in space is not compared with that of a reference that has none.
  void write_reference(bool is_spatial) {
    std::string text(kHeader);
    for (const Reference::Point& point : reference_->trajectory) {
      Pose pose = point.T_map_base;
      if (!point.has_yaw) pose.q = Eigen::Quaterniond::Identity();
      if (is_spatial && point.is_planar) pose.p.z() = std::numeric_limits<double>::quiet_NaN();
      text += line(point.stamp, pose);
    }
    write_file(out_dir_ / reference_name_, text);
    reference_.reset();
  }

  std::string trajectory_name_;
  std::string path_name_;
  std::string reference_name_;
  std::string covariance_name_;
  std::filesystem::path out_dir_;
  std::shared_ptr<const Reference> reference_;  // until it is written
  std::optional<OutputFile> trajectory_;        // open from start() to finish()
  std::optional<OutputFile> covariance_;
  bool has_covariance_header_ = false;
};

}  // namespace
}  // namespace waymark::tum

WAYMARK_PLUGIN(waymark::Sink, waymark::tum::Tum, "tum", "1.0.0")
