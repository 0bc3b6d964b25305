// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "fusion/dead_reckoning.hpp"
#include "waymark/host/fusion_settings.hpp"

namespace waymark::fusion {

/// Start of the filter.
struct Start {
  Belief prior;
  bool draw = false;              ///< the particles draw their start from the prior; otherwise it is the map's gauge
  std::uint32_t used_sensor = 0;  ///< the measurement that gave the position, if `used`; not to be fused again
  std::uint64_t used_sequence = 0;
  bool used = false;
  /// Covariance of (x, y, yaw) of a start pose that absolute sensors found and that is the map's gauge: it is reported,
  /// and not estimated.
  Eigen::Matrix3d frame = Eigen::Matrix3d::Zero();
  bool keeps_pose = false;  ///< of a new start: the position before, with the covariance of the prior
};

/// What gives or constrains the start pose.
struct StartSources {
  bool has_absolute;    ///< an absolute sensor can find the start, fused afterwards or not
  bool fuses_absolute;  ///< an absolute sensor is fused after the start
  bool has_prior_map;   ///< a map is loaded
};

/// Finds the start pose: from the YAML, from a fix, the heading from a compass, or from fixes and the path between them
/// by dead reckoning (docs/math/start.md). Where no sensor measures the speed, from the course between two fixes.
class StartFinder {
 public:
  /// `process_model` must outlive the object.
  StartFinder(const StartSettings& settings, const estimation::ProcessModel& process_model, Duration standstill_after,
              StartSources sources)
      : settings_(settings),
        process_model_(process_model),
        layout_(process_model.layout()),
        standstill_after_(standstill_after),
        sources_(sources) {}

  /// Adds the next measurement, with its sensor's hint. `before` holds those before it, in any order: a first fix may
  /// be late. Returns the start once it is known.
  std::optional<Start> process(const Measurement& measurement, const std::optional<StartHint>& hint,
                               const std::vector<SensorRecord>& sensors, const std::vector<Measurement>& before);

  /// Begins the search anew.
  void restart(const StartSettings& settings, StartSources sources);
  /// True if the position is known: given, or measured.
  bool has_position() const { return settings_.position || !first_fixes_.empty(); }
  /// The missing information, as a text for users.
  std::string missing() const;

 private:
  struct Fix {
    std::uint32_t sensor;
    Time stamp;
    std::uint64_t sequence;
    StartHint hint;
    double farthest = 0.0;  ///< distance of a later fix of the same sensor, at most [m]
  };

  Start make_start(Time stamp, const Fix* fix) const;

  const Fix* first_fix() const { return first_fixes_.empty() ? nullptr : &first_fixes_.front(); }
  void add_fix(const Measurement& measurement, const StartHint& hint, const std::vector<SensorRecord>& sensors,
               const std::vector<Measurement>& before);
  void find_heading_on_path();
  void find_heading_on_chord(const StartHint& hint, const Fix& first);
  double least_chord(double sigma) const;
  std::string missing_heading() const;

  StartSettings settings_;
  const estimation::ProcessModel& process_model_;
  const StateLayout& layout_;
  Duration standstill_after_;
  StartSources sources_;
  std::vector<Fix> first_fixes_;            // the first of each sensor, in their order
  std::optional<DeadReckoning> reckoning_;  // since the first fix, unless the YAML gives the heading
  std::optional<double> yaw_;
  double yaw_sigma_ = 0.0;
  std::optional<double> path_sigma_;  // of the last heading on the path that was not good enough [rad]
};

}  // namespace waymark::fusion
