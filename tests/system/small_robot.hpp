// SPDX-License-Identifier: Apache-2.0
// A small robot with a log of its own, written by the test: 30 s along a straight line among pillars.
#pragma once

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "tests/system/command.hpp"

namespace waymark::system_test {

constexpr double kDuration = 30.0;  // s
constexpr double kSpeed = 0.5;      // m/s
constexpr double kNoReturn = 40.0;  // m
constexpr int kBeams = 121;         // 1.5 degrees apart, from -90 degrees

/// A log as lines of text (the first is the header), and the YAML that reads it. Tests change either before they run
/// it.
class SmallRobot {
 public:
  SmallRobot() {
    twist.push_back("t_s,v_mps,w_radps");
    for (int i = 0; i <= 50 * static_cast<int>(kDuration); ++i) {
      twist.push_back(
          fmt::format("{:.3f},{:.6f},{:.6f}", i / 50.0, kSpeed + 0.01 * std::sin(1.3 * i), 0.005 * std::cos(2.1 * i)));
    }
    fixes.push_back("t_s,east_m,north_m");
    for (int i = 0; i < static_cast<int>(kDuration); ++i) {
      const double t = i + 0.25;
      fixes.push_back(
          fmt::format("{:.3f},{:.4f},{:.4f}", t, kSpeed * t + 0.2 * std::sin(3.7 * i), 0.2 * std::cos(2.9 * i)));
    }
    std::string header = "t_s";
    for (int k = 0; k < kBeams; ++k) header += fmt::format(",r{}", k);
    scans.push_back(header);
    for (int i = 0; i < 5 * static_cast<int>(kDuration); ++i) scans.push_back(scan(i / 5.0 + 0.1));
  }

  std::vector<std::string> twist;
  std::vector<std::string> fixes;
  std::vector<std::string> scans;
  std::string yaml = R"(source:
  plugin: csv
  max_bad_rows: 0
  files:
    - path: twist.csv
      sensor: wheels
      payload: BodyTwist
      time: t_s
      columns: { v_x_mps: v_mps, w_z_radps: w_radps }
    - path: fixes.csv
      sensor: gps
      payload: GnssFix
      time: t_s
      columns: { east_m: east_m, north_m: north_m }
    - path: scans.csv
      sensor: lidar
      payload: LaserScan
      time: t_s
      columns: { ranges_m: { first: r0, last: r120 } }
      scan: { start_deg: -90, step_deg: 1.5 }
initial: { x_m: 0, y_m: 0, position_sigma_m: 0.1, yaw_deg: 0, yaw_sigma_deg: 2.0 }
motion: { kind: planar }
sensors:
  - name: wheels
    plugin: odometry
    model: twist
  - name: gps
    plugin: dgps
    base_p_antenna_m: [0, 0, 0]
    sigma_m: 0.3
  - name: lidar
    payload: LaserScan
    base_T_sensor: { xyz_m: [0, 0, 0], yaw_deg: 0 }
maps:
  - name: pillars
    plugin: feature_map
    inputs: [lidar]
    extraction: { range_min_m: 0.2, range_max_m: 14.5, no_return_m: 39, segment_jump_m: 0.5, background_m: 0.8, width_max_m: 1.2 }
    noise: { range_m: 0.05, bearing_deg: 0.5 }
    association: { new_landmark_density_per_m2: 0.01 }
    existence: { view_range_m: 12 }
filter: { particles: 5, seed: 1 }
sinks:
  - { plugin: tum }
  - { plugin: landmarks }
  - { plugin: diagnostics }
)";

  std::filesystem::path file(std::string_view name) const { return folder_ / name; }
  std::filesystem::path out() const { return folder_ / "out"; }
  std::string place(std::string_view file_name, std::size_t line) const {
    return fmt::format("{}:{}", file(file_name).string(), line);
  }

  /// The line of the YAML (from 1) in which `text` first occurs.
  std::size_t yaml_line(std::string_view text) const {
    const std::size_t at = yaml.find(text);
    if (at == std::string::npos) throw std::logic_error("the YAML does not hold " + std::string(text));
    return 1 + static_cast<std::size_t>(std::count(yaml.begin(), yaml.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
  }

  SmallRobot& replace(std::string_view old_text, std::string_view new_text) {
    const std::size_t at = yaml.find(old_text);
    if (at == std::string::npos) throw std::logic_error("the YAML does not hold " + std::string(old_text));
    yaml.replace(at, old_text.size(), new_text);
    return *this;
  }

  void write() const {
    write_text(file("robot.yaml"), yaml);
    for (const auto& [name, lines] :
         {std::pair("twist.csv", &twist), std::pair("fixes.csv", &fixes), std::pair("scans.csv", &scans)}) {
      std::string text;
      for (const std::string& line : *lines) text += line + "\n";
      write_text(file(name), text);
    }
  }

  Command command(std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments{"run", file("robot.yaml").string(), "--out", out().string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Command(std::move(arguments));
  }
  Outcome run(std::vector<std::string> more = {}) const {
    write();
    return command(std::move(more)).run();
  }
  Outcome check() const {
    write();
    return waymark({"check", file("robot.yaml").string()});
  }

  /// Passes if trajectory, path, landmarks and diagnostics are there and complete.
  testing::AssertionResult has_results(std::size_t trajectory_rows) const {
    for (const auto& [name, least] : {std::pair<const char*, std::size_t>{"trajectory.txt", trajectory_rows},
                                      {"path.txt", 1},
                                      {"landmarks.csv", 1}}) {
      if (auto result = has_complete_lines(out() / name, least); !result) return result;
    }
    const std::string diagnostics = read_text(out() / "diagnostics.json");
    if (!diagnostics.starts_with("{") || !diagnostics.ends_with("}\n"))
      return testing::AssertionFailure() << "diagnostics.json is not complete";
    return has_no_partial_file(out());
  }

 private:
  static std::string scan(double t) {
    constexpr std::array<std::array<double, 2>, 6> pillars{{{4, 3}, {6, -3}, {9, 4}, {12, -4}, {16, 3}, {18, -3}}};
    constexpr double kRadius = 0.2;
    std::string row = fmt::format("{:.3f}", t);
    for (int k = 0; k < kBeams; ++k) {
      const double bearing = (-90.0 + 1.5 * k) * 3.14159265358979 / 180.0;
      double range = kNoReturn;
      for (const auto& pillar : pillars) {
        const double x = pillar[0] - kSpeed * t;
        const double along = x * std::cos(bearing) + pillar[1] * std::sin(bearing);
        const double across = x * std::sin(bearing) - pillar[1] * std::cos(bearing);
        if (along > 0.0 && std::abs(across) < kRadius)
          range = std::min(range, along - std::sqrt(kRadius * kRadius - across * across));
      }
      row += fmt::format(",{:.3f}", range < 14.0 ? range : kNoReturn);
    }
    return row;
  }

  TemporaryFolder folder_;
};

}  // namespace waymark::system_test
