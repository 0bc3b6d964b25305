// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/calibration/magnetometer.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/waymark/calibration/log_reader.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::calibration {

namespace {

constexpr double kWidestGap = 0.5 * std::numbers::pi;
constexpr double kKnownShare = 0.05;  // of the strength: 3° of heading

std::optional<Eigen::Vector3d> field_of(const Measurement& measurement) {
  const std::string_view type = measurement.payload->type();
  Eigen::Vector3d field = Eigen::Vector3d::Constant(std::nan(""));
  if (type == ImuSample::kType) field = measurement.as<ImuSample>().m_sensor;
  if (type == MagneticField::kType) field = measurement.as<MagneticField>().m_sensor;
  if (!field.allFinite()) return std::nullopt;
  return field;
}

/// R.m.s. of the strength in the fitted axes about its mean, as a share.
double scatter_of_strength(const std::vector<Eigen::Vector3d>& calibrated, int axes) {
  double sum = 0.0;
  double squares = 0.0;
  for (const Eigen::Vector3d& field : calibrated) {
    const double strength = field.head(axes).norm();
    sum += strength;
    squares += strength * strength;
  }
  const double mean = sum / static_cast<double>(calibrated.size());
  return std::sqrt(std::max(0.0, squares / static_cast<double>(calibrated.size()) - mean * mean)) / mean;
}

void read_given_iron(const Config& sensor, Magnetometer& out) {
  if (sensor.has(kHardIron)) {
    const std::vector<double> h = sensor.numbers(kHardIron, 3);
    out.given_hard = {h[0], h[1], h[2]};
  }
  if (!sensor.has(kSoftIron)) return;
  const std::vector<double> a = sensor.numbers(kSoftIron, 9);
  out.given_soft << a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7], a[8];
}

/// From the axes of the base into those of the sensor.
void turn_iron_into_sensor(const Eigen::Matrix3d& R_base_sensor, Magnetometer& out) {
  Eigen::Vector3d hard = out.iron.hard;
  if (out.iron.axes == 2) hard.z() = (R_base_sensor * out.given_hard).z();
  out.hard = R_base_sensor.transpose() * hard;
  const Eigen::Matrix3d covariance = out.iron.hard_sigma.cwiseAbs2().asDiagonal();
  out.hard_sigma = (R_base_sensor.transpose() * covariance * R_base_sensor).diagonal().cwiseMax(0.0).cwiseSqrt();
  out.soft = R_base_sensor.transpose() * out.iron.soft * R_base_sensor;
}

}  // namespace

bool Magnetometer::is_determined() const {
  return iron.gap_rad < kWidestGap && iron.hard_sigma.maxCoeff() < kKnownShare * iron.strength;
}

std::vector<Magnetometer> magnetometers_over_log(const std::filesystem::path& yaml,
                                                 const std::vector<Config::Override>& overrides,
                                                 std::optional<double> until_s,
                                                 const std::vector<std::string>& sensors) {
  LogReader log(yaml, overrides, until_s);
  const host::Robot& robot = log.robot();
  std::vector<std::vector<Eigen::Vector3d>> fields(robot.sensors.size());
  while (std::optional<Measurement> m = log.next()) {
    if (const std::optional<Eigen::Vector3d> field = field_of(*m)) fields[m->sensor].push_back(*field);
  }
  std::vector<Magnetometer> all;
  for (const Config& sensor : robot.yaml.items("sensors")) {
    const std::string name = sensor.text("name");
    if (std::ranges::find(sensors, name) == sensors.end()) continue;
    const auto slot = std::ranges::find(robot.sensors, name, &SensorSlot::name);
    if (slot == robot.sensors.end()) continue;
    std::vector<Eigen::Vector3d>& readings = fields[static_cast<std::size_t>(slot - robot.sensors.begin())];
    const Eigen::Matrix3d R_base_sensor = robot.rig.T_base_sensor(name).q.toRotationMatrix();
    std::vector<Eigen::Vector3d> in_base = readings;
    for (Eigen::Vector3d& field : in_base) field = R_base_sensor * field;
    const std::optional<Iron> iron = fit_iron(in_base);
    if (!iron) continue;
    Magnetometer found;
    found.sensor = name;
    found.has_keys = sensor.has("plugin") && sensor.text("plugin") == "compass";
    found.readings = static_cast<long>(readings.size());
    found.iron = *iron;
    read_given_iron(sensor, found);
    turn_iron_into_sensor(R_base_sensor, found);
    for (Eigen::Vector3d& field : readings) field = R_base_sensor * (found.given_soft * (field - found.given_hard));
    found.given_scatter = scatter_of_strength(readings, iron->axes);
    all.push_back(std::move(found));
  }
  return all;
}

}  // namespace waymark::calibration
