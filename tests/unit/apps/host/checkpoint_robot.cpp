// SPDX-License-Identifier: Apache-2.0
#include "unit/apps/host/checkpoint_robot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>

#include "waymark/base/error.hpp"
#include "waymark/host/robot.hpp"

namespace waymark::test {

namespace {

constexpr double kSavedAfter = 0.8;  // of the log

constexpr const char* kSource = R"(
source:
  plugin: simulator
  duration_s: 5
  course: { waypoints_m: [0, 0, 20, 0] }
  ceiling_m: 3
  walls_m: [-3, -4, 12, -4]
  landmarks: { list_m: [3, 2, 0.2, 5, -2, 0.2, 6, 3, 0.2, 1, -2, 0.2] }
  wheels: { sensor: wheels, rate_hz: 10, track_m: 0.5, noise_m_per_sqrt_s: 0.01 }
  gps: { sensor: gps, rate_hz: 5, sigma_m: 0.3, delay_jitter_s: 0.3, satellite_change_mean_s: 3 }
  imu: { sensor: imu, rate_hz: 20 }
  compass: { sensor: compass, rate_hz: 4 }
)";
constexpr const char* kScanners = R"(
  lidar: { sensor: lidar, rate_hz: 4, range_max_m: 8, start_deg: -90, step_deg: 2, beams: 91, sigma_m: 0.02 }
  lidar_3d: { sensor: lidar_3d, rate_hz: 2, rings: 4, beams: 45, step_deg: 8, range_max_m: 8 }
)";
constexpr const char* kRobot = R"(
initial: { x_m: 0, y_m: 0, position_sigma_m: 0.1, yaw_deg: 0, yaw_sigma_deg: 2 }
motion: { kind: planar }
sensors:
  - { name: wheels, plugin: odometry, model: differential, track_m: 0.5 }
  - { name: gps, plugin: dgps, base_p_antenna_m: [0, 0, 0], sigma_m: 0.3, offset_sigma_m: 0.5, offset_tau_s: 60,
      adaptive_noise: true }
  - { name: imu, plugin: imu, tilt: false, base_T_sensor: { xyz_m: [0, 0, 0] } }
  - { name: compass, plugin: compass, sigma_deg: 2, declination_deg: 0, base_T_sensor: { xyz_m: [0, 0, 0] } }
)";
constexpr const char* kMaps = R"(
  - { name: lidar, payload: LaserScan, base_T_sensor: { xyz_m: [0.2, 0, 0.3] } }
  - { name: lidar_3d, payload: PointCloud, base_T_sensor: { xyz_m: [0.2, 0, 0.8] } }
maps:
  - name: pillars
    plugin: feature_map
    inputs: [lidar]
    keep_sightings: true
    extraction: { range_min_m: 0.2, range_max_m: 7.5, no_return_m: 8.5,
        segment_jump_m: 0.3, background_m: 0.8, width_max_m: 0.8 }
    noise: { range_m: 0.04, bearing_deg: 0.4 }
    association: { new_landmark_density_per_m2: 0.01 }
    existence: { view_range_m: 7 }
  - { name: floor, plugin: occupancy_grid, inputs: [lidar], resolution_m: 0.2,
      range_max_m: 7.5, no_return_m: 8.5, update_distance_m: 0.2 }
  - { name: voxels, plugin: octomap_grid, inputs: [lidar_3d], resolution_m: 0.3, range_max_m: 7.5 }
filter: { particles: 3, history_s: 0.5 }
)";

constexpr const char* kGridRobot = R"(
source:
  plugin: simulator
  duration_s: 30
  speed_mps: 1
  course: { waypoints_m: [0, 0, 4, 0, 4, 3, 0, 3], laps: 2 }
  walls_m: [-2, -2, 7, -2, 7, -2, 7, 5, 7, 5, -2, 5, -2, 5, -2, -2, 1, -2, 1, -1, 5, 5, 5, 4.2, -2, 2, -1.4, 2]
  wheels: { sensor: wheels, rate_hz: 10, track_m: 0.5, noise_m_per_sqrt_s: 0.03 }
  lidar: { sensor: lidar, rate_hz: 4, range_max_m: 8, start_deg: -90, step_deg: 4, beams: 46, sigma_m: 0.02 }
initial: { x_m: 0, y_m: 0, yaw_deg: 0 }
motion: { kind: planar }
sensors:
  - { name: wheels, plugin: odometry, model: differential, track_m: 0.5 }
  - { name: lidar, payload: LaserScan, base_T_sensor: { xyz_m: [0.2, 0, 0.3] } }
maps: [{ name: floor, plugin: occupancy_grid, inputs: [lidar], resolution_m: 0.2, range_max_m: 7.5 }]
filter: { particles: 3 }
)";
constexpr const char* kLoops = "loops: { least_way_m: 5, least_shift_m: 0.01 }\n";

/// A map of one wall, which is far from all that the robot sees.
void write_map(const TemporaryFolder& folder) {
  constexpr int kSide = 40;
  std::string cells(kSide * kSide, static_cast<char>(254));
  for (std::size_t column = 5; column < 20; ++column) cells[3 * kSide + column] = 0;
  std::ofstream(folder / "map.pgm", std::ios::binary) << fmt::format("P5\n{0} {0}\n255\n", kSide) << cells;
  std::ofstream(folder / "map.yaml") << "image: map.pgm\nresolution: 0.2\norigin: [-4, -4, 0]\nnegate: 0\n"
                                        "occupied_thresh: 0.65\nfree_thresh: 0.196\n";
}

/// Numbers that do harm where they are counts, indices, sizes, times, enums, or parts of a state.
constexpr std::array<std::uint64_t, 16> kHarmful = {0,
                                                    1,
                                                    2,
                                                    3,
                                                    64,
                                                    255,
                                                    0x7fff'ffff,
                                                    0x8000'0000,
                                                    0xffff'ffff,
                                                    std::uint64_t{1} << 33,
                                                    0x7fff'ffff'ffff'ffff,
                                                    0x8000'0000'0000'0000,
                                                    0xffff'ffff'ffff'ffff,
                                                    std::bit_cast<std::uint64_t>(-1.0),
                                                    std::bit_cast<std::uint64_t>(1e300),
                                                    std::bit_cast<std::uint64_t>(1e-300)};

/// The same numbers with every standard library, unlike the distributions of <random>.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : engine_(seed) {}
  std::size_t below(std::size_t limit) { return static_cast<std::size_t>(engine_() % limit); }

 private:
  std::mt19937_64 engine_;
};

/// Where a change is likely to meet something else than a cell of a map: half of all shortly behind a section's mark.
std::size_t place(const std::string& state, Draws& draws) {
  if (state.empty() || draws.below(2) == 0) return draws.below(state.size() + 1);
  const std::size_t section = state.find("SECT", draws.below(state.size()));
  if (section == std::string::npos) return draws.below(state.size() + 1);
  return std::min(section + draws.below(240), state.size() - 1);
}

void overwrite(std::string& state, std::size_t at, std::uint64_t number, std::size_t size) {
  if (at < state.size()) std::memcpy(state.data() + at, &number, std::min(size, state.size() - at));
}

void damage(std::string& state, Draws& draws) {
  const std::size_t at = place(state, draws);
  switch (draws.below(8)) {
    case 0:
    case 1:
      if (at < state.size()) state[at] = static_cast<char>(state[at] ^ (1 << draws.below(8)));
      break;
    case 2:
      overwrite(state, at, kHarmful[draws.below(kHarmful.size())], 1);
      break;
    case 3:
      overwrite(state, at, kHarmful[draws.below(kHarmful.size())], 4);
      break;
    case 4:
      overwrite(state, at, kHarmful[draws.below(kHarmful.size())], 8);
      break;
    case 5: {  // a piece of another place, such as the number of a shared object
      const std::size_t size = 1 + draws.below(32);
      const std::string piece = state.substr(place(state, draws), size);
      state.replace(std::min(at, state.size()), piece.size(), piece);
      break;
    }
    case 6:
      if (draws.below(2) == 0) {
        state.erase(std::min(at, state.size()), 1 + draws.below(16));
      } else {
        state.insert(std::min(at, state.size()), state.substr(std::min(at, state.size()), 1 + draws.below(16)));
      }
      break;
    default:
      if (draws.below(4) == 0) state.resize(std::min(at, state.size()));
      break;
  }
}

}  // namespace

CheckpointRobot::CheckpointRobot(Kind kind) : kind_(kind), loader_({WAYMARK_PLUGIN_DIR}) {
  if (kind_ == Kind::misplaced) write_map(folder_);
  const host::Robot robot = host::Robot::load(config(1), loader_);
  while (auto measurement = robot.source->next()) {
    if (robot.assign(*measurement)) log_.push_back(std::move(*measurement));
  }
  saved_after_ = static_cast<std::size_t>(kSavedAfter * static_cast<double>(log_.size()));
  state_ = saved_again(1);
}

std::string CheckpointRobot::state_of(const Fusion& fusion) const {
  std::ostringstream stream;
  OutArchive out(stream);
  kind_ == Kind::running ? fusion.save_with_measurements(out) : fusion.save(out);
  return stream.str();
}

Config CheckpointRobot::config(int threads) const {
  const std::string set_threads = fmt::format("filter.threads={}", threads);
  if (kind_ == Kind::loops) return Config::parse(std::string(kGridRobot) + kLoops, "robot.yaml", {set_threads});
  if (kind_ == Kind::misplaced) {
    return Config::parse(kGridRobot, "robot.yaml",
                         {set_threads, "source.duration_s=6", "maps.floor.mode=localize",
                          fmt::format("maps.floor.load={}", (folder_ / "map.yaml").string())});
  }
  std::string yaml = kSource;
  if (kind_ == Kind::maps) yaml += kScanners;
  yaml += kRobot;
  if (kind_ == Kind::maps) yaml += kMaps;
  if (kind_ == Kind::rollback) yaml += "filter: { smooth: true, history_s: 1 }\n";
  if (kind_ == Kind::running) yaml += "filter: { history_s: 1, max_latency_s: 0.4 }\n";
  return Config::parse(yaml, "robot.yaml", {set_threads});
}

std::string CheckpointRobot::saved_again(int threads) const {
  const auto fusion = host::Robot::load(config(threads), loader_).fusion(nullptr);
  for (std::size_t i = 0; i < saved_after_; ++i) fusion->add(log_[i]);
  return state_of(*fusion);
}

std::optional<std::string> CheckpointRobot::load(std::string_view state) const {
  const auto fusion = host::Robot::live(config(1), loader_).fusion(nullptr);
  std::size_t next = kind_ == Kind::running ? saved_after_ : 0;
  std::istringstream stream{std::string(state)};
  InArchive in(stream);
  try {
    if (kind_ == Kind::running) {
      fusion->resume_with_measurements(in);
    } else {
      fusion->resume(in, [&]() -> std::optional<Measurement> {
        if (next == log_.size()) return std::nullopt;
        return log_[next++];
      });
    }
  } catch (const DataError& error) {
    return error.what();
  }
  while (next < log_.size()) fusion->add(log_[next++]);
  fusion->finish();
  fusion->report();
  fusion->visit_last([](const Snapshot& last) {
    last.particles();
    last.best_path();
    for (const MapDetail detail : {MapDetail::with_mixtures, MapDetail::with_files}) {
      try {
        last.best_maps(detail);
      } catch (const Error&) {  // a sink reports it: too large for a picture
      }
    }
  });
  std::ostringstream again;
  OutArchive out(again);
  fusion->save(out);
  return std::nullopt;
}

std::string CheckpointRobot::damaged(std::uint64_t number) const {
  Draws draws(number);
  std::string state = state_;
  const std::size_t changes = 1 + draws.below(3);
  for (std::size_t i = 0; i < changes; ++i) damage(state, draws);
  return state;
}

}  // namespace waymark::test
