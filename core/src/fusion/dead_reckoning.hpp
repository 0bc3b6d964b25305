// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <deque>
#include <memory>
#include <vector>

#include "estimation/ekf.hpp"
#include "estimation/heading_fit.hpp"
#include "estimation/process_model.hpp"
#include "fusion/sensor_record.hpp"
#include "monitoring/standstill.hpp"
#include "waymark/host/fusion_settings.hpp"

namespace waymark::fusion {

/// Dead reckoning while the start is searched: the motion since the first fix, in a frame of its own that has the base
/// at its origin then. One Gaussian with clones of the sensors that measure the motion, their own states included;
/// fixes do not correct it. It keeps the points of the robot that were fixed, with their joint covariance.
class DeadReckoning {
 public:
  /// `process` must outlive the object.
  DeadReckoning(const estimation::ProcessModel& process, const StartSettings& settings, Duration standstill_after,
                const std::vector<SensorRecord>& sensors, Time begin);

  /// Keeps the measurement, if its sensor measures the motion, until a fix is added: a fix may arrive later than the
  /// motion after it. What is older than the last fix is left out.
  void process(const Measurement& m);
  /// Adds a fix of `p_base_point`, after the motion up to it. Of many fixes some are left out, but not the first and
  /// the last. One that is older than the last one is ignored.
  void add_fix(const Measurement& m, const StartHint& hint);
  /// True if the forward speed is measured: without it nothing is known of the path.
  bool measures_speed() const { return measures_speed_; }
  /// The heading of the base at the begin, out of path and fixes; nothing if the points lie within `least_distance`
  /// [m].
  std::optional<estimation::HeadingFit> heading(double least_distance) const;
  /// The way driven up to the last fix, by the motion sensors [m].
  double way() const { return way_; }

 private:
  /// A point that was fixed, and its covariance with the present state.
  struct Point {
    estimation::ReckonedFix fix;
    estimation::ekf::Innovation::Gain with_state;  // size × 2
  };
  void advance(Time to);
  void process_motion(const Measurement& m);
  void predict(Time to);
  void update(int block_offset, const Update& update);
  void set_standing(const Measurement& m, const UpdateList& updates);
  void forget_twist();
  void thin_out();

  const estimation::ProcessModel& process_;
  StartSettings settings_;
  Belief belief_;
  monitoring::Standstill standstill_;
  std::vector<std::unique_ptr<Sensor>> sensors_;  // null: measures no motion
  std::deque<Measurement> waiting_;               // motion after the last fix, by stamp
  std::vector<Point> points_;
  Eigen::MatrixXd joint_;   // covariance of the points
  double way_ = 0.0;        // [m]
  bool has_moved_ = false;  // a motion was measured
  bool measures_speed_ = false;
  UpdateList updates_;
};

}  // namespace waymark::fusion
