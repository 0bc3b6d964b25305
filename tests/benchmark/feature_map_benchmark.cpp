// SPDX-License-Identifier: Apache-2.0
// What the feature map costs per particle. All landmarks stand in squares of one density; the robot is in the middle.
#include <benchmark/benchmark.h>

#include <cmath>
#include <map>
#include <numbers>
#include <sstream>

#include "tests/unit/map_modules/feature_map/feature_map_bench.hpp"
#include "waymark/math/random.hpp"

namespace waymark::feature_map {
namespace {

using feature_map_test::detection_of;
using feature_map_test::gaussian_at;
using feature_map_test::landmark_at;
using feature_map_test::observation_of;
using feature_map_test::settings_of;

constexpr double kReach = 30.0;         // [m], of the sensor
constexpr std::size_t kDetections = 8;  // per scan

/// `count` landmarks, of which about `in_reach` stand within kReach of the origin.
LandmarkStore field(int count, double in_reach) {
  Random random({.seed = 3, .slot = 0, .stamp = 0, .sensor = 0});
  const double side = std::sqrt(count * std::numbers::pi * kReach * kReach / in_reach);
  LandmarkStore store;
  for (int i = 0; i < count; ++i) {
    const double east = side * (random.uniform() - 0.5);
    store.add(landmark_at(east, side * (random.uniform() - 0.5)));
  }
  return store;
}

void clone(benchmark::State& state) {
  const LandmarkStore store = field(static_cast<int>(state.range(0)), 100.0);
  for (auto _ : state) {
    LandmarkStore copy = store;
    benchmark::DoNotOptimize(copy);
  }
}
BENCHMARK(clone)->RangeMultiplier(10)->Range(100, 100000);

/// One landmark is written after the particle was copied: the way to its leaf is cloned.
void clone_and_write(benchmark::State& state) {
  const LandmarkStore store = field(static_cast<int>(state.range(0)), 100.0);
  LandmarkRef ref;
  store.for_near({0.0, 0.0}, 10.0, [&](LandmarkRef found, const auto&) { ref = found; });
  const Landmark landmark = store.at(ref);
  for (auto _ : state) {
    LandmarkStore copy = store;
    copy.write(ref, landmark);
    benchmark::DoNotOptimize(copy);
  }
}
BENCHMARK(clone_and_write)->RangeMultiplier(10)->Range(100, 100000);

void search_near(benchmark::State& state) {
  const LandmarkStore store = field(static_cast<int>(state.range(0)), 100.0);
  std::int64_t found = 0;
  for (auto _ : state) {
    store.for_near({3.0, 2.0}, 5.0, [&](LandmarkRef ref, const auto&) { found += ref.place; });
    benchmark::DoNotOptimize(found);
  }
}
BENCHMARK(search_near)->RangeMultiplier(10)->Range(100, 100000);

/// A particle's map in one piece: loaded from an archive, because only steps fill it otherwise.
ParticleFeatureMap map_of(const LandmarkStore& store, const std::shared_ptr<const FeatureMapSettings>& settings) {
  std::stringstream stream;
  OutArchive out(stream);
  out.section("feature_map", 1);
  out.value(0.5);
  out.value(1.0);
  store.save(out);
  InArchive in(stream);
  ParticleFeatureMap map(settings);
  map.load(in);
  return map;
}

/// A whole mapping step of one particle, arguments: landmarks in all, landmarks in reach. Counter `s_per_observation`:
/// seconds per detection.
void refine_and_insert(benchmark::State& state) {
  const auto in_reach = static_cast<double>(state.range(1));
  const LandmarkStore store = field(static_cast<int>(state.range(0)), in_reach);
  const auto settings = std::make_shared<const FeatureMapSettings>(settings_of("{ existence: { view_range_m: 30 } }"));
  ParticleFeatureMap map = map_of(store, settings);

  const Eigen::Vector3d pose(0.0, 0.0, 0.3);
  // Landmarks in front, in the order of their ids, so that the layout of the store does not matter.
  std::map<std::int64_t, Detection> in_front;
  store.for_near({0.0, 0.0}, kReach, [&](LandmarkRef, const Landmark& landmark) {
    const Detection detection = detection_of(landmark.mean.head<2>() + Eigen::Vector2d(0.02, -0.01), pose);
    if (detection.xyr.x() > 3.0) in_front[landmark.id] = detection;
  });
  std::vector<Detection> detections;
  for (const auto& [id, detection] : in_front) {
    if (detections.size() < kDetections) detections.push_back(detection);
  }
  FeatureObservation observation = observation_of(detections);
  observation.max_range = kReach;
  // Something stands before everything that was not detected, as in a scene where nothing is missing.
  observation.view.start = -0.5 * std::numbers::pi;
  observation.view.step = std::numbers::pi / 360.0;
  observation.view.ranges.assign(361, 5.0f);

  const Eigen::Matrix3d prior = Eigen::Vector3d(1e-3, 1e-3, 1e-6).asDiagonal();
  Refinement refinement;
  for (auto _ : state) {
    refinement.log_evidence = 0.0;
    refinement.information.setZero();
    refinement.gradient.setZero();
    map.refine(gaussian_at(pose, prior), Pose::planar(pose.x(), pose.y(), pose.z()), observation, refinement);
    map.insert(gaussian_at(pose, 0.5 * prior), observation, refinement.association.get());
  }
  state.counters["detections"] = static_cast<double>(detections.size());
  state.counters["s_per_observation"] =
      benchmark::Counter(static_cast<double>(detections.size()),
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(refine_and_insert)
    ->Args({400, 100})
    ->Args({1600, 400})
    ->Args({4000, 1000})
    ->Args({100, 100})
    ->Args({1000, 100})
    ->Args({10000, 100})
    ->Args({100000, 100});

}  // namespace
}  // namespace waymark::feature_map
