// SPDX-License-Identifier: Apache-2.0
// The attitude filter of sensors/imu on the trials of BROAD and RepoIMU, one set of parameters for all, as the table of
// docs/results/imu.md. Beside it Madgwick's filter on the same samples.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "attitude_filter.hpp"
#include "imu_recordings.hpp"
#include "madgwick.hpp"

namespace {

using namespace waymark;       // NOLINT(google-build-using-namespace)
using namespace waymark::imu;  // NOLINT(google-build-using-namespace)

constexpr double kMadgwickBeta = 0.12;  // [rad/s], best on average over the 39 trials of BROAD, says that repository

struct Result {
  Errors errors;
  Errors best_frames;
  double microseconds = 0.0;  // per sample
};

enum class Axes { nine, six };

Result run(const Recording& recording, bool align, const AttitudeSettings& settings, Axes axes) {
  AttitudeFilter filter(settings);
  std::vector<Eigen::Quaterniond> estimate;
  estimate.reserve(recording.samples.size());
  const auto start = std::chrono::steady_clock::now();
  for (const Recording::Sample& sample : recording.samples) {
    ImuSample imu = sample.imu;
    if (axes == Axes::six) imu.m_sensor.setConstant(ImuSample::kUnknown);
    filter.process(sample.stamp, imu);
    estimate.push_back(filter.q_map_sensor());
  }
  const std::chrono::duration<double, std::micro> time = std::chrono::steady_clock::now() - start;
  return {compare(recording, estimate, align), compare_best_frames(recording, estimate),
          time.count() / static_cast<double>(estimate.size())};
}

Errors run_madgwick(const Recording& recording, bool align) {
  Madgwick filter(kMadgwickBeta);
  std::vector<Eigen::Quaterniond> estimate;
  Time last = recording.samples.front().stamp;
  for (const Recording::Sample& sample : recording.samples) {
    filter.process(sample.imu.w_sensor, sample.imu.f_sensor, sample.imu.m_sensor, to_seconds(sample.stamp - last));
    last = sample.stamp;
    estimate.push_back(filter.q_map_sensor());
  }
  return compare(recording, estimate, align);
}

std::vector<std::filesystem::path> trials(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".gz") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string text(const Errors& errors) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, "%.2f / %.2f / %.2f", errors.total, errors.heading, errors.inclination);
  return buffer;
}

/// One table: total / heading / inclination [deg] per trial and their means.
void report(const std::filesystem::path& folder, Recording (*read)(const std::filesystem::path&), bool align,
            const AttitudeSettings& settings) {
  std::puts(
      "| trial | this filter | without magnetometer: inclination | Madgwick, own code | best constant frames | "
      "µs/sample |");
  std::puts("|---|---|---|---|---|---|");
  Errors sum;
  Errors madgwick_sum;
  double inclination_sum = 0.0;
  double count = 0.0;
  for (const auto& file : trials(folder)) {
    const Recording recording = read(file);
    const Result nine = run(recording, align, settings, Axes::nine);
    const Result six = run(recording, align, settings, Axes::six);
    const Errors madgwick = run_madgwick(recording, align);
    std::printf("| %s | %s | %.2f | %s | %s | %.1f |\n", recording.name.c_str(), text(nine.errors).c_str(),
                six.errors.inclination, text(madgwick).c_str(), text(nine.best_frames).c_str(), nine.microseconds);
    for (const auto& [total, one] : {std::pair(&sum, &nine.errors), std::pair(&madgwick_sum, &madgwick)}) {
      total->total += one->total;
      total->heading += one->heading;
      total->inclination += one->inclination;
    }
    inclination_sum += six.errors.inclination;
    count += 1.0;
  }
  const auto mean = [&](const Errors& e) { return Errors{e.total / count, e.heading / count, e.inclination / count}; };
  std::printf("| mean | %s | %.2f | %s | | |\n\n", text(mean(sum)).c_str(), inclination_sum / count,
              text(mean(madgwick_sum)).c_str());
}

}  // namespace

int main(int argc, char** argv) {
  const char* data = argc > 1 ? argv[1] : std::getenv("WAYMARK_DATA");
  if (data == nullptr || argc > 2) {
    std::fputs("usage: imu_benchmark_accuracy [FOLDER], which holds broad/ and repoimu/; default: WAYMARK_DATA\n",
               stderr);
    return 2;
  }
  try {
    const AttitudeSettings settings;
    std::puts("Root mean square of the error [deg], total / heading / inclination.\n\nBROAD\n");
    report(std::filesystem::path(data) / "broad", &read_broad, false, settings);
    std::puts("RepoIMU\n");
    report(std::filesystem::path(data) / "repoimu", &read_repoimu, true, settings);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "imu_benchmark_accuracy: %s\n", error.what());
    return 1;
  }
  return 0;
}
