// SPDX-License-Identifier: Apache-2.0
// What one particle pays for one scan on octrees: planar, against the flat grid, and in three dimensions, against
// copying OctoMap's own tree of the same map.
#include <benchmark/benchmark.h>
#include <octomap/OcTree.h>

#include <array>
#include <sstream>

#include "map_modules/occupancy_grid/particle_grid.hpp"
#include "map_modules/octomap_grid/octomap_file.hpp"
#include "tests/unit/map_modules/occupancy_grid/simulated_room.hpp"
#include "tests/unit/map_modules/octomap_grid/simulated_hall.hpp"

namespace waymark::octomap_grid_test {
namespace {

/// A map that was driven through five times, and scans of it.
template <class Map>
struct Drive {
  void step(std::size_t i, double error) {
    refine(i, error);
    insert(map, i);
  }
  void refine(std::size_t i, double error) {
    refinement.information.setZero();
    refinement.gradient.setZero();
    const Eigen::Matrix3d P = Eigen::Vector3d(9e-4, 4e-4, 1e-3).asDiagonal();
    PoseGaussian prior{way[i], P};
    prior.T_map_base.p += Eigen::Vector3d(error, -error, 0.0);
    map.refine(prior, prior.T_map_base, *scans[i], refinement);
  }
  void insert(Map& into, std::size_t i) const {
    into.insert({way[i], Eigen::Matrix3d::Zero()}, *scans[i], refinement.association.get());
  }
  void drive(int rounds) {
    for (int round = 0; round < rounds; ++round) {
      for (std::size_t i = 0; i < way.size(); ++i) step(i, 0.0);
    }
  }

  Map map;
  std::vector<Pose> way;
  std::vector<std::shared_ptr<const Observation>> scans;
  Refinement refinement = {};
};

const std::vector<Pose> kPlanarWay = {Pose::planar(0, 0, 0),     Pose::planar(1, 0, 0.4),   Pose::planar(1.8, 0.6, 1.5),
                                      Pose::planar(0, 0.4, 2.8), Pose::planar(-2, 0, -2.5), Pose::planar(-1, -1, -1)};

LaserScan planar_scan(std::size_t i) {
  const Pose& p = kPlanarWay[i];
  return occupancy_grid_test::scan_of(occupancy_grid_test::room(), {p.p.x(), p.p.y(), p.yaw()}, 0.02,
                                      static_cast<std::uint32_t>(i));
}

Drive<occupancy_grid::ParticleGrid> flat_drive() {
  Drive<occupancy_grid::ParticleGrid> drive{
      occupancy_grid::ParticleGrid(std::make_shared<occupancy_grid::GridModel>(occupancy_grid_test::settings())),
      kPlanarWay,
      {}};
  for (std::size_t i = 0; i < kPlanarWay.size(); ++i) {
    drive.scans.push_back(std::make_shared<occupancy_grid::ScanObservation>(
        occupancy_grid::observe(planar_scan(i), Pose{}, {}, occupancy_grid_test::settings().scan)));
  }
  drive.drive(5);
  return drive;
}

Drive<ParticleOctomap> octomap_drive() {
  const OctomapGridSettings s = settings("{ resolution_m: 0.05 }");
  Drive<ParticleOctomap> drive{ParticleOctomap(std::make_shared<OctomapModel>(s)), kPlanarWay, {}};
  for (std::size_t i = 0; i < kPlanarWay.size(); ++i)
    drive.scans.push_back(std::make_shared<CloudObservation>(observe(planar_scan(i), Pose{}, {}, s)));
  drive.drive(5);
  return drive;
}

template <class Make>
void planar_refine(benchmark::State& state, const Make& make) {
  auto drive = make();
  std::size_t i = 0;
  for (auto _ : state) drive.refine(i++ % drive.way.size(), 0.03);
}
BENCHMARK_CAPTURE(planar_refine, flat, flat_drive);
BENCHMARK_CAPTURE(planar_refine, octomap, octomap_drive);

template <class Make>
void planar_insert(benchmark::State& state, const Make& make) {
  auto drive = make();
  std::size_t i = 0;
  for (auto _ : state) drive.insert(drive.map, i++ % drive.way.size());
}
BENCHMARK_CAPTURE(planar_insert, flat, flat_drive);
BENCHMARK_CAPTURE(planar_insert, octomap, octomap_drive);

/// Clouds of 16 × 900 points in a hall of 35 m × 25 m with pillars, driven through five times.
Drive<ParticleOctomap> hall_drive() {
  Hall hall;
  hall.boxes.front() = {{-15.03, -10.04, -0.53}, {20.02, 15.03, 4.04}};
  for (int x = 0; x < 4; ++x) {
    for (int y = 0; y < 3; ++y)
      hall.boxes.push_back({{8.0 * x - 11.0, 8.0 * y - 6.0, -0.53}, {8.0 * x - 10.2, 8.0 * y - 5.2, 4.04}});
  }
  const OctomapGridSettings s = settings("{ resolution_m: 0.1, range_max_m: 40 }");
  Drive<ParticleOctomap> drive{ParticleOctomap(std::make_shared<OctomapModel>(s)), {}, {}};
  for (int i = 0; i < 12; ++i) drive.way.push_back(Pose::planar(2.0 * i - 10.0, 0.2 * i - 1.0, 0.3 * i));
  const Pose T_base_sensor{Eigen::Quaterniond::Identity(), {0.0, 0.0, 1.0}};
  // Every round with noise of its own, as a robot sees it; the last one is measured.
  for (std::uint32_t round = 0; round < 6; ++round) {
    drive.scans.clear();
    for (std::size_t i = 0; i < drive.way.size(); ++i) {
      const PointCloud cloud =
          cloud_of(hall, drive.way[i] * T_base_sensor, 0.02, 100 * round + static_cast<std::uint32_t>(i), 16, 900);
      drive.scans.push_back(std::make_shared<CloudObservation>(observe(cloud, T_base_sensor, {}, s)));
    }
    if (round < 5) drive.drive(1);
  }
  return drive;
}

Drive<ParticleOctomap>& hall() {
  static Drive<ParticleOctomap> drive = hall_drive();
  return drive;
}

std::unique_ptr<octomap::OcTree> whole_tree() {
  auto tree = std::make_unique<octomap::OcTree>(0.1);
  std::istringstream file(octomap_files(hall().map.voxels(), 0.1)[1].content);
  std::string line;
  while (std::getline(file, line) && line != "data") {
  }
  tree->readData(file);
  return tree;
}

void hall_copy_of_octomaps_tree(benchmark::State& state) {
  const auto tree = whole_tree();
  for (auto _ : state) {
    const octomap::OcTree copy(*tree);
    benchmark::DoNotOptimize(&copy);
  }
  state.counters["nodes"] = static_cast<double>(tree->size());
  state.counters["tree_bytes"] = static_cast<double>(tree->memoryUsage());
}
BENCHMARK(hall_copy_of_octomaps_tree)->Unit(benchmark::kMicrosecond);

/// The same cloud as in the rows below, written into OctoMap's tree by OctoMap.
void hall_insert_into_octomaps_tree(benchmark::State& state) {
  const auto tree = whole_tree();
  const std::size_t at = hall().way.size() / 2;
  const auto& seen = static_cast<const CloudObservation&>(*hall().scans[at]);
  octomap::Pointcloud cloud;
  for (const Eigen::Vector3f& p : seen.hits) {
    const Eigen::Vector3d p_map = hall().way[at] * p.cast<double>();
    cloud.push_back(static_cast<float>(p_map.x()), static_cast<float>(p_map.y()), static_cast<float>(p_map.z()));
  }
  const Eigen::Vector3f from = (hall().way[at] * seen.p_base_sensor).cast<float>();
  for (auto _ : state) tree->insertPointCloud(cloud, {from.x(), from.y(), from.z()});
}
BENCHMARK(hall_insert_into_octomaps_tree)->Unit(benchmark::kMicrosecond);

void hall_clone(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(hall().map.clone());
}
BENCHMARK(hall_clone);

/// Copies a particle and writes a scan that it has not seen before into the copy; `own_bytes` are what that cloned.
void hall_clone_and_insert(benchmark::State& state) {
  const std::size_t at = hall().way.size() / 2;
  hall().refine(at, 0.0);
  for (auto _ : state) {
    ParticleOctomap copy = hall().map;
    hall().insert(copy, at);
  }
  ParticleOctomap copy = hall().map;
  hall().insert(copy, at);
  const std::array<const VoxelMap*, 2> both{&hall().map.voxels(), &copy.voxels()};
  const std::size_t one = VoxelMap::bytes_of(std::span(both).first(1));
  state.counters["map_bytes"] = static_cast<double>(one);
  state.counters["own_bytes"] = static_cast<double>(VoxelMap::bytes_of(both) - one);
}
BENCHMARK(hall_clone_and_insert)->Unit(benchmark::kMicrosecond);

/// A copy that shares nothing.
ParticleOctomap deep_copy(const ParticleOctomap& map) {
  std::stringstream stream;
  OutArchive out(stream);
  map.save(out);
  ParticleOctomap copy(std::make_shared<OctomapModel>(settings("{ resolution_m: 0.1, range_max_m: 40 }")));
  InArchive in(stream);
  copy.load(in);
  return copy;
}

/// The same scan written into the same map where nothing is shared: what is more above is the price of sharing.
void hall_first_insert(benchmark::State& state) {
  const std::size_t at = hall().way.size() / 2;
  hall().refine(at, 0.0);
  for (auto _ : state) {
    state.PauseTiming();
    auto copy = std::make_unique<ParticleOctomap>(deep_copy(hall().map));
    state.ResumeTiming();
    hall().insert(*copy, at);
    state.PauseTiming();
    copy.reset();
    state.ResumeTiming();
  }
}
BENCHMARK(hall_first_insert)->Unit(benchmark::kMicrosecond);

/// The same scan again and again into one map: nothing is shared, and soon nothing changes.
void hall_insert(benchmark::State& state) {
  const std::size_t at = hall().way.size() / 2;
  hall().refine(at, 0.0);
  ParticleOctomap copy = hall().map;
  hall().insert(copy, at);
  for (auto _ : state) hall().insert(copy, at);
}
BENCHMARK(hall_insert)->Unit(benchmark::kMicrosecond);

void hall_refine(benchmark::State& state) {
  std::size_t i = 0;
  for (auto _ : state) hall().refine(i++ % hall().way.size(), 0.03);
}
BENCHMARK(hall_refine)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace waymark::octomap_grid_test
