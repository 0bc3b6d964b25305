// SPDX-License-Identifier: Apache-2.0
// What one particle pays for one scan of 180 beams, and for being copied.
#include <benchmark/benchmark.h>

#include "tests/unit/map_modules/occupancy_grid/simulated_room.hpp"

namespace waymark::occupancy_grid_test {
namespace {

const std::vector<Eigen::Vector3d> kWay = {{0, 0, 0},     {1, 0, 0.4},   {1.8, 0.6, 1.5},
                                           {0, 0.4, 2.8}, {-2, 0, -2.5}, {-1, -1, -1}};

struct Drive {
  Drive() {
    for (std::size_t i = 0; i < kWay.size(); ++i)
      scans.push_back(observed(room(), kWay[i], 0.02, static_cast<std::uint32_t>(i)));
    for (int round = 0; round < 5; ++round) {
      for (std::size_t i = 0; i < kWay.size(); ++i) step(i, 0.0);
    }
  }
  void refine(std::size_t i, double error) {
    const Eigen::Vector3d& at = kWay[i];
    refinement.information.setZero();
    refinement.gradient.setZero();
    const Eigen::Matrix3d P = Eigen::Vector3d(9e-4, 4e-4, 1e-3).asDiagonal();
    const PoseGaussian prior{Pose::planar(at.x() + error, at.y() - error, at.z() + 0.5 * error), P};
    grid.refine(prior, prior.T_map_base, scans[i], refinement);
  }
  void insert(std::size_t i) {
    grid.insert({Pose::planar(kWay[i].x(), kWay[i].y(), kWay[i].z()), Eigen::Matrix3d::Zero()}, scans[i],
                refinement.association.get());
  }
  void step(std::size_t i, double error) {
    refine(i, error);
    insert(i);
  }

  std::shared_ptr<const GridModel> model = std::make_shared<GridModel>(settings());
  ParticleGrid grid{model};
  std::vector<ScanObservation> scans;
  Refinement refinement;
};

void refine(benchmark::State& state) {
  Drive drive;
  std::size_t i = 0;
  for (auto _ : state) drive.refine(i++ % kWay.size(), 0.03);
}
BENCHMARK(refine);

void insert(benchmark::State& state) {
  Drive drive;
  drive.refine(0, 0.0);
  std::size_t i = 0;
  for (auto _ : state) drive.insert(i++ % kWay.size());
}
BENCHMARK(insert);

void refine_and_insert(benchmark::State& state) {
  Drive drive;
  std::size_t i = 0;
  for (auto _ : state) drive.step(i++ % kWay.size(), 0.03);
}
BENCHMARK(refine_and_insert);

/// A map of `range` × `range` tiles.
void copy_particle(benchmark::State& state) {
  TileTree tiles;
  for (int x = 0; x < state.range(0); ++x) {
    for (int y = 0; y < state.range(0); ++y) tiles.write({x, y}).odds.set(0, 1);
  }
  for (auto _ : state) {
    const TileTree copy = tiles;
    benchmark::DoNotOptimize(&copy);
  }
}
BENCHMARK(copy_particle)->Arg(4)->Arg(64);

}  // namespace
}  // namespace waymark::occupancy_grid_test
