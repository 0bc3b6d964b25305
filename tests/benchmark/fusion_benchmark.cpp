// SPDX-License-Identifier: Apache-2.0
// Throughput of the whole host on the workload W-fuse: a robot on a circle, 200 slots a second, half of them IMU, a
// quarter odometry, a quarter position; 15 error states. One thread. docs/results/benchmarks.md has the figures.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "unit/core/beliefs.hpp"
#include "waymark/host/robot.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark {
namespace {

constexpr double kSpeed = 1.0;
constexpr double kRate = 0.1;
constexpr double kSlot = 0.005;
constexpr int kSlots = 20000;

Measurement reading(int slot, std::uint32_t sensor, std::shared_ptr<const Payload> payload) {
  Measurement m;
  m.stamp = m.arrival = test::at(kSlot * slot);
  m.sensor = sensor;
  m.sequence = static_cast<std::uint64_t>(slot);
  m.payload = std::move(payload);
  return m;
}

/// The circle; positions arrive `late` slots after they were true.
std::vector<Measurement> circle(int late) {
  Random random = test::stream(5);
  std::vector<Measurement> log;
  for (int k = 0; k < kSlots; ++k) {
    const double t = kSlot * k;
    if (k % 2 == 0) {
      auto imu = std::make_shared<ImuSample>();
      imu->w_sensor = {1e-3 * random.normal(), 1e-3 * random.normal(), kRate + 1e-3 * random.normal()};
      imu->f_sensor = {0.02 * random.normal(), kSpeed * kRate + 0.02 * random.normal(), 9.81 + 0.02 * random.normal()};
      log.push_back(reading(k, 0, imu));
    } else if (k % 4 == 1) {
      auto twist = std::make_shared<BodyTwist>();
      twist->v_x_mps = kSpeed + 0.05 * random.normal();
      twist->w_z_radps = kRate + 0.02 * random.normal();
      log.push_back(reading(k, 1, twist));
    } else {
      auto fix = std::make_shared<GnssFix>();
      fix->p_map_antenna = {kSpeed / kRate * std::sin(kRate * t) + 0.5 * random.normal(),
                            kSpeed / kRate * (1.0 - std::cos(kRate * t)) + 0.5 * random.normal(),
                            0.5 * random.normal()};
      log.push_back(reading(k, 2, fix));
      log.back().arrival += from_seconds(kSlot * late);
    }
  }
  std::stable_sort(log.begin(), log.end(), [](const auto& a, const auto& b) { return a.arrival < b.arrival; });
  return log;
}

std::unique_ptr<Fusion> make_fusion(const PluginLoader& loader, int particles) {
  const Config yaml = Config::parse(
      "{ motion: { kind: spatial }, filter: { history_s: 2, particles: " + std::to_string(particles) +
          " }, initial: { x_m: 0, y_m: 0, yaw_deg: 0, position_sigma_m: 1, yaw_sigma_deg: 5 }, sensors: ["
          "{ name: imu, plugin: imu, reports_standstill: false, base_T_sensor: { xyz_m: [0, 0, 0] } },"
          // The wheels without errors as states: 16 error states, as when the figures of the page were taken.
          "{ name: wheels, plugin: odometry, model: twist, speed_scale_sigma: 0, curvature_sigma_per_m: 0, "
          "yaw_scale_sigma: 0 },"
          "{ name: gps, plugin: dgps, base_p_antenna_m: [0.2, 0, 0.5], sigma_m: 0.5, sigma_vertical_m: 0.5, "
          "offset_sigma_m: 1, offset_vertical_sigma_m: 1, offset_tau_s: 60 }] }",
      "w_fuse.yaml");
  return host::Robot::live(yaml, loader).fusion(nullptr);
}

void w_fuse(benchmark::State& state) {
  const PluginLoader loader({WAYMARK_PLUGIN_DIR});
  const std::vector<Measurement> log = circle(static_cast<int>(state.range(1)));
  double square_error = 0.0;
  int states = 0;
  for (auto _ : state) {
    state.PauseTiming();
    auto fusion = make_fusion(loader, static_cast<int>(state.range(0)));
    state.ResumeTiming();
    for (const Measurement& m : log) fusion->add(m);
    fusion->finish();
    const Pose pose = fusion->front(test::at(kSlot * (kSlots - 1))).mean.T_map_base;
    const double t = kSlot * (kSlots - 1);
    square_error = std::hypot(pose.p.x() - kSpeed / kRate * std::sin(kRate * t),
                              pose.p.y() - kSpeed / kRate * (1.0 - std::cos(kRate * t)));
    states = fusion->layout().size();
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * kSlots);
  state.counters["us_per_measurement"] = benchmark::Counter(static_cast<double>(state.iterations()) * kSlots * 1e-6,
                                                            benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["end_error_m"] = square_error;
  state.SetLabel(std::to_string(states) + " error states");
}
BENCHMARK(w_fuse)
    ->ArgNames({"particles", "slots_late"})
    ->Args({1, 0})
    ->Args({1, 20})
    ->Args({1, 100})
    ->Args({100, 0})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace waymark

BENCHMARK_MAIN();
