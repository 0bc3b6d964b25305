// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "waymark/host/robot.hpp"
#include "waymark/interface/finding.hpp"

namespace waymark::host {

/// Two observers of one quantity, and how they compare.
struct Comparison {
  std::string quantity;  ///< "yaw", "way"
  std::string first;     ///< "wheels", "gps chords"
  std::string second;
  double ratio = 0.0;  ///< of the first one's changes to the second one's
  double sigma = 0.0;
  long spans = 0;
  std::string verdict;  ///< "agree", "differ", "unrelated", "not known"
};

/// Cross-checks of all sensors of a robot, beside its filter and independent of it (docs/doctor.md): what contradicts
/// what, which sensor is likely configured wrongly, and which line of the YAML would fit.
///
/// Statistics are gathered with every measurement, and evaluated after 30 s of the log, each time that has doubled, and
/// at the end. Windows of about seven minutes follow each other.
class Diagnosis {
 public:
  /// `robot` must outlive it.
  explicit Diagnosis(const Robot& robot);
  ~Diagnosis();
  Diagnosis(const Diagnosis&) = delete;
  Diagnosis& operator=(const Diagnosis&) = delete;

  /// Takes a measurement in order of arrival. `Measurement::sensor` is an index into the robot's sensors.
  void arrived(const Measurement& measurement);
  /// Notes the stamp of a measurement that is not compared any more: whether all sensors deliver, in one time.
  void note(const Measurement& measurement);
  /// True if every enabled sensor has delivered.
  bool has_all_sensors() const;
  /// Evaluates what there is, at the end of the log.
  void finish();

  /// All that is certain so far, in the order in which it became so.
  const std::vector<Finding>& findings() const;
  /// Findings since the last call.
  std::vector<Finding> take_new();
  /// The comparisons of the last evaluation.
  const std::vector<Comparison>& comparisons() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace waymark::host
