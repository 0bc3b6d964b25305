// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/paper/course.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "apps/waymark/evaluation/consistency.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::paper {
namespace {

using evaluation::Trajectory;

/// The odometry's noise times a factor, in the simulator and in the settings of the filter: `--noise` measures how much
/// noise the method bears, not what a wrong model does.
std::vector<std::string> with_noise(const std::filesystem::path& config, std::vector<std::string> overrides,
                                    double factor) {
  const Config yaml = Config::load(config, overrides);
  const Config wheels = yaml.child("source").child("wheels");
  overrides.push_back(fmt::format("source.wheels.noise_m_per_sqrt_s={}", factor * wheels.number("noise_m_per_sqrt_s")));
  const std::string name = wheels.text("sensor");
  for (const Config& sensor : yaml.items("sensors")) {
    if (sensor.text("name") != name) continue;
    for (const char* key : {"speed_noise_m_per_sqrt_s", "yaw_noise_rad_per_sqrt_s"}) {
      std::vector<double> noise = sensor.numbers(key);
      for (double& part : noise) part *= factor;
      overrides.push_back(fmt::format("sensors.{}.{}=[{}]", name, key, fmt::join(noise, ", ")));
    }
  }
  return overrides;
}

std::vector<evaluation::Landmark> survey_of(const Source& source) {
  const auto reference = source.reference();
  if (reference == nullptr || reference->landmarks.empty() || reference->trajectory.empty())
    throw Error("paper: the source has no ground truth; config must use the simulator");
  std::vector<evaluation::Landmark> survey;
  for (const Reference::Landmark& landmark : reference->landmarks)
    survey.push_back({landmark.name, landmark.p_map, landmark.radius_m});
  return survey;
}

/// Between two things of the survey [m].
double least_distance(const std::vector<evaluation::Landmark>& survey) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < survey.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) least = std::min(least, (survey[i].p_map - survey[k].p_map).norm());
  }
  return least;
}

/// One scenario under way: its own robot, fed with the measurements of another one's source.
class Run {
 public:
  Run(host::Robot robot, const std::filesystem::path& pictures)
      : truth_(truth_of(*robot.source)),
        survey_(survey_of(*robot.source)),
        session_(std::move(robot), {.out = pictures,
                                    .owns_folder = false,
                                    .observer = [this](const Snapshot& snapshot, double) { watch(snapshot); }}) {}

  Source& source() { return *session_.robot().source; }

  void add(Measurement measurement) {
    if (session_.robot().assign(measurement)) session_.add(std::move(measurement));
  }

  Trial finish() {
    refuse_failures(session_.finish());
    if (online_.points.empty()) throw Error("paper: the filter has mapped nothing");
    session_.fusion().visit_last([&](const Snapshot& last) { score(last); });
    return trial_;
  }

 private:
  void watch(const Snapshot& snapshot) {
    if (!snapshot.started()) return;
    const Eigen::Matrix3d P = pose_covariance(snapshot.belief(), snapshot.layout());
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(P.topLeftCorner<2, 2>(), Eigen::EigenvaluesOnly);
    trial_.widest_sigma_m = std::max(trial_.widest_sigma_m, std::sqrt(std::max(0.0, axes.eigenvalues().y())));
    if (snapshot.fate() != Fate::mapped || snapshot.measurement().payload->type() != LaserScan::kType) return;
    online_.points.push_back({snapshot.stamp(), snapshot.belief().mean.T_map_base});
    covariances_.push_back({snapshot.stamp(), P});
  }

  void score(const Snapshot& last) {
    constexpr double kGap = 1.0;   // [s]
    constexpr int kConfirmed = 3;  // sightings: fewer are no landmark
    const double match_radius = 0.5 * least_distance(survey_);
    const evaluation::TrajectoryOptions options;
    const auto online = evaluation::score_trajectory(online_, truth_, options);
    trial_.position_rms_m = online.position_m.rms;
    trial_.yaw_rms_rad = online.yaw_rad ? online.yaw_rad->rms : 0.0;
    Pose true_end;
    if (evaluation::pose_at(truth_, online_.points.back().stamp, kGap, true_end) == evaluation::Lookup::found)
      trial_.position_end_m = (online_.points.back().pose.p - true_end.p).head<2>().norm();
    trial_.nees_mean = evaluation::score_consistency(covariances_, online_, truth_, {.max_time_gap_s = kGap}).nees.mean;
    Trajectory path{"path", false, evaluation::Orientation::yaw, {}};
    for (const StampedPose& pose : last.best_path()) path.points.push_back({pose.stamp, pose.T_map_base});
    trial_.path_rms_m = evaluation::score_trajectory(path, truth_, options).position_m.rms;

    const std::vector<MapDescription> maps = last.best_maps(MapDetail::summary);
    std::vector<evaluation::Landmark> landmarks;
    for (const LandmarkView& landmark : maps.front().landmarks) {
      if (landmark.confirmed)
        landmarks.push_back({std::to_string(landmark.id), landmark.p_map, landmark.radius_m, landmark.sightings});
    }
    trial_.landmarks = evaluation::score_landmarks(landmarks, survey_, Pose{}, {match_radius, kConfirmed});
    trial_.associations =
        evaluation::score_associations(maps.front().sightings, truth_, survey_, match_radius, kConfirmed);
  }

  Trajectory truth_;
  std::vector<evaluation::Landmark> survey_;
  Trajectory online_{"estimate", false, evaluation::Orientation::yaw, {}};
  std::vector<evaluation::PoseCovariance> covariances_;
  Trial trial_;
  host::Session session_;  // last: it calls watch()
};

}  // namespace

Trajectory truth_of(const Source& source) {
  if (source.reference() == nullptr)
    throw Error("paper: the source has no ground truth; config must use the simulator");
  Trajectory truth{"truth", false, evaluation::Orientation::yaw, {}};
  for (const Reference::Point& point : source.reference()->trajectory)
    truth.points.push_back({point.stamp, point.T_map_base});
  return truth;
}

void refuse_failures(const host::SessionResult& result) {
  for (const Event& event : result.report.events) {
    if (event.is_failure) throw Error("paper: " + event.text);
  }
  if (!result.log_error.empty()) throw Error(result.log_error);
  if (!result.started) throw Error("paper: the filter has not started");
  if (!result.failures.empty()) throw Error("paper: " + result.failures.front());
}

std::vector<Trial> run(const std::filesystem::path& config, const std::vector<std::string>& overrides,
                       const Course& course, const std::vector<Scenario>& scenarios) {
  std::vector<std::unique_ptr<Run>> runs;
  for (const Scenario& scenario : scenarios) {
    const std::filesystem::path file = scenario.config.empty() ? config : std::filesystem::path(scenario.config);
    std::vector<std::string> own = with_noise(file, overrides, course.noise);
    own.push_back(fmt::format("source.seed={}", course.seed));
    own.push_back(fmt::format("filter.seed={}", course.seed));
    own.emplace_back("filter.threads=1");
    own.emplace_back("maps.0.keep_sightings=true");
    own.insert(own.end(), scenario.overrides.begin(), scenario.overrides.end());
    own.push_back(course.pictures.empty() ? "sinks=[]"
                                          : fmt::format("sinks=[{{plugin: plot, file: {}}}]", scenario.picture));
    runs.push_back(std::make_unique<Run>(host::Robot::load(file, own), course.pictures));
  }
  Source& source = runs.front()->source();
  while (std::optional<Measurement> measurement = source.next()) {
    for (const auto& run : runs) run->add(*measurement);
  }
  std::vector<Trial> trials;
  trials.reserve(runs.size());
  for (const auto& run : runs) trials.push_back(run->finish());
  return trials;
}

std::vector<evaluation::Landmark> surveyed(const std::filesystem::path& config,
                                           const std::vector<std::string>& overrides) {
  return survey_of(*host::Robot::load(config, overrides).source);
}

}  // namespace waymark::paper
