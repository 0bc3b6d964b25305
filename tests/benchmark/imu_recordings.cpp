// SPDX-License-Identifier: Apache-2.0
#include "imu_recordings.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>
#include <numbers>
#include <string_view>

#include "waymark/base/error.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::imu {

namespace {

struct Row {
  Time stamp;
  std::vector<double> numbers;  // all columns, the time among them
};

/// The rows below `header_lines` lines; `columns` numbers in each.
std::vector<Row> read_table(const std::filesystem::path& file, char delimiter, int header_lines, std::size_t columns) {
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> stream(gzopen(file.c_str(), "rb"), &gzclose);
  if (!stream) throw DataError("cannot open " + file.string());
  std::vector<Row> rows;
  std::array<char, 4096> line{};
  for (int number = 1; gzgets(stream.get(), line.data(), static_cast<int>(line.size())) != nullptr; ++number) {
    if (number <= header_lines) continue;
    std::string_view rest(line.data());
    while (!rest.empty() && (rest.back() == '\n' || rest.back() == '\r')) rest.remove_suffix(1);
    if (rest.empty()) continue;
    Row row;
    row.stamp = parse_time(rest.substr(0, rest.find(delimiter)));
    while (row.numbers.size() < columns) {
      const std::string field(rest.substr(0, rest.find(delimiter)));
      char* end = nullptr;
      row.numbers.push_back(std::strtod(field.c_str(), &end));
      if (field.empty() || *end != '\0')
        throw DataError(file.string() + ":" + std::to_string(number) + ": \"" + field + "\" is not a number");
      rest.remove_prefix(std::min(field.size() + 1, rest.size()));
    }
    rows.push_back(std::move(row));
  }
  int code = Z_OK;
  const char* message = gzerror(stream.get(), &code);
  if (code != Z_OK && code != Z_STREAM_END) throw DataError(file.string() + ": " + message);
  if (rows.empty()) throw DataError(file.string() + " has no rows");
  return rows;
}

std::string trial_name(const std::filesystem::path& file) {
  const std::string name = file.filename().string();
  return name.substr(0, name.find(".csv"));
}

}  // namespace

Recording read_broad(const std::filesystem::path& file) {
  Recording recording{trial_name(file), {}};
  for (const Row& row : read_table(file, ',', 1, 18)) {
    const double* n = row.numbers.data();
    Recording::Sample sample;
    sample.stamp = row.stamp;
    sample.imu.w_sensor = Eigen::Vector3d(n + 1);
    sample.imu.f_sensor = Eigen::Vector3d(n + 4);
    sample.imu.m_sensor = Eigen::Vector3d(n + 7);
    sample.q_world_sensor = Eigen::Quaterniond(n[10], n[11], n[12], n[13]).normalized();
    sample.counts = n[17] == 1.0 && std::isfinite(n[10]);
    recording.samples.push_back(sample);
  }
  return recording;
}

Recording read_repoimu(const std::filesystem::path& file) {
  Recording recording{trial_name(file), {}};
  const bool at_rest = recording.name.ends_with("_Static");
  for (const Row& row : read_table(file, ';', 2, 14)) {
    const double* n = row.numbers.data();
    Recording::Sample sample;
    sample.stamp = row.stamp;
    Eigen::Quaterniond q(n[1], n[2], n[3], n[4]);
    if (at_rest) q.setIdentity();
    sample.counts = q.norm() > 0.5;
    sample.q_world_sensor = sample.counts ? q.normalized() : q;
    sample.imu.f_sensor = Eigen::Vector3d(n + 5);
    sample.imu.w_sensor = Eigen::Vector3d(n + 8);
    sample.imu.m_sensor = Eigen::Vector3d(n + 11);
    recording.samples.push_back(sample);
  }
  return recording;
}

Errors compare(const Recording& recording, const std::vector<Eigen::Quaterniond>& estimate, bool align) {
  Eigen::Quaterniond q_map_world = Eigen::Quaterniond::Identity();
  Eigen::Array3d sum = Eigen::Array3d::Zero();
  std::size_t count = 0;
  for (std::size_t i = 0; i < recording.samples.size(); ++i) {
    const Recording::Sample& sample = recording.samples[i];
    if (!sample.counts) continue;
    if (align && count == 0) q_map_world = estimate[i] * sample.q_world_sensor.conjugate();
    const Eigen::Quaterniond error = estimate[i] * (q_map_world * sample.q_world_sensor).conjugate();
    const double vertical = std::hypot(error.w(), error.z());
    const Eigen::Array3d angles(2.0 * std::atan2(error.vec().norm(), std::abs(error.w())),
                                2.0 * std::atan2(std::abs(error.z()), std::abs(error.w())),
                                2.0 * std::atan2(error.vec().head<2>().norm(), vertical));
    sum += angles.square();
    ++count;
  }
  if (count == 0) throw DataError(recording.name + ": no sample counts");
  const Eigen::Array3d rms = (sum / static_cast<double>(count)).sqrt() * (180.0 / std::numbers::pi);
  return {rms(0), rms(1), rms(2)};
}

Errors compare_best_frames(const Recording& recording, const std::vector<Eigen::Quaterniond>& estimate) {
  Recording fitted = recording;
  const auto mean = [&](const auto& error) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double count = 0.0;
    for (std::size_t i = 0; i < estimate.size(); ++i) {
      if (!fitted.samples[i].counts) continue;
      sum += so3::log(error(estimate[i], fitted.samples[i].q_world_sensor));
      count += 1.0;
    }
    return so3::exp(sum / std::max(count, 1.0));
  };
  constexpr int kRounds = 100;  // each takes out the mean error of the one frame, then of the other
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::Quaterniond world = mean([](const auto& q, const auto& truth) { return q * truth.conjugate(); });
    for (auto& sample : fitted.samples) sample.q_world_sensor = world * sample.q_world_sensor;
    const Eigen::Quaterniond body = mean([](const auto& q, const auto& truth) { return truth.conjugate() * q; });
    for (auto& sample : fitted.samples) sample.q_world_sensor = sample.q_world_sensor * body;
  }
  return compare(fitted, estimate, false);
}

}  // namespace waymark::imu
