// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <filesystem>
#include <string>
#include <vector>

#include "waymark/base/time.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::imu {

/// One trial of an orientation benchmark.
struct Recording {
  struct Sample {
    Time stamp;
    ImuSample imu;                      ///< the magnetic field in the unit of the file
    Eigen::Quaterniond q_world_sensor;  ///< truth; NaN where the cameras lost the body
    bool counts = false;                ///< belongs to the phases that the metric looks at, and the truth is known
  };
  std::string name;
  std::vector<Sample> samples;
};

/// Root mean square errors over the samples that count [deg]: of the whole rotation between estimate and truth, its
/// part about the vertical, and the rest (definition of BROAD: D. Laidig et al., Data 6(7):72, 2021).
struct Errors {
  double total = 0.0;
  double heading = 0.0;
  double inclination = 0.0;
};

/// Reads a trial of BROAD as CSV. Throws DataError.
Recording read_broad(const std::filesystem::path& file);
/// Reads a trial of RepoIMU. Rows with an all-zero truth do not count, but the trial at rest has no other: its truth is
/// that nothing turns. Throws DataError.
Recording read_repoimu(const std::filesystem::path& file);

/// `estimate` has one attitude per sample. With `align` the truth's world is turned so that both agree in the first
/// sample that counts.
Errors compare(const Recording& recording, const std::vector<Eigen::Quaterniond>& estimate, bool align);
/// The same with the two constant rotations, of the truth's world and of its body frame, that fit best over the whole
/// trial: what is left then is no matter of how the cameras' frames were set up. Not a figure to compare filters by.
Errors compare_best_frames(const Recording& recording, const std::vector<Eigen::Quaterniond>& estimate);

}  // namespace waymark::imu
