// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>

#include "simulated_log.hpp"

namespace waymark {
namespace {

using test::kWheels;
using test::make;

struct Refusal {
  const char* what;
  std::string yaml;
  const char* message;
};

class SimulatorRefuses : public ::testing::TestWithParam<Refusal> {};

TEST_P(SimulatorRefuses, WithOneClearMessage) {
  try {
    make(GetParam().yaml);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find(GetParam().message), std::string::npos) << error.what();
  }
}

const std::string kOk = "{ duration_s: 5, course: { waypoints_m: [0, 0, 5, 0, 5, 5] }";

INSTANTIATE_TEST_SUITE_P(
    Yaml, SimulatorRefuses,
    ::testing::Values(
        Refusal{"NoSensor", kOk + "}", "wheels, gps, lidar"},
        Refusal{"ZeroWheelNoise", kOk + ", wheels: { sensor: wheels, track_m: 1, noise_m_per_sqrt_s: 0 } }",
                "noise_m_per_sqrt_s"},
        Refusal{"NegativeWheelNoise", kOk + ", wheels: { sensor: wheels, track_m: 1, noise_m_per_sqrt_s: -1 } }",
                "noise_m_per_sqrt_s"},
        Refusal{"ZeroGpsNoise", kOk + ", gps: { sensor: gps, sigma_m: 0 } }", "sigma_m"},
        Refusal{"NegativeGpsNoise", kOk + ", gps: { sensor: gps, sigma_m: -0.1 } }", "sigma_m"},
        Refusal{"NegativeOffset", kOk + ", gps: { sensor: gps, correlated_sigma_m: -0.1 } }", "correlated_sigma_m"},
        Refusal{"ZeroRangeNoise", kOk + ", lidar: { sensor: lidar, sigma_m: 0 } }", "sigma_m"},
        Refusal{"NegativeRangeNoise", kOk + ", lidar: { sensor: lidar, sigma_m: -0.1 } }", "sigma_m"},
        Refusal{"ZeroRate", kOk + ", gps: { sensor: gps, rate_hz: 0 } }", "rate_hz"},
        Refusal{"OutageThatEndsBeforeItBegins", kOk + ", gps: { sensor: gps, outages_s: [20, 10] } }", "outages_s"},
        Refusal{"OddOutages", kOk + ", gps: { sensor: gps, outages_s: [20] } }", "outages_s"},
        Refusal{"UnknownLidar", kOk + ", lidar: { sensor: scanner } }", "scanner"},
        Refusal{"OneWayPoint", "{ duration_s: 5, course: { waypoints_m: [0, 0] }" + kWheels + "}", "waypoints_m"},
        Refusal{"EqualWayPoints", "{ duration_s: 5, course: { waypoints_m: [0, 0, 1, 1, 1, 1] }" + kWheels + "}",
                "waypoints_m"},
        Refusal{"LapsOfAnOpenCourse", "{ duration_s: 5, course: { waypoints_m: [0, 0, 1, 1], laps: 2 }" + kWheels + "}",
                "laps"},
        Refusal{"ShortLookahead", kOk + ", lookahead_m: 0.5" + kWheels + "}", "lookahead_m"},
        Refusal{"LandmarkOnTheCourse", kOk + ", landmarks: { list_m: [2, 0.1, 0.2] }" + kWheels + "}", "landmark 1"},
        Refusal{"LandmarkWithoutRadius", kOk + ", landmarks: { list_m: [2, 9, 0] }" + kWheels + "}", "radius"},
        Refusal{"CountAndList", kOk + ", landmarks: { count: 2, list_m: [2, 9, 0.1] }" + kWheels + "}", "not both"},
        Refusal{"NegativeBeamWidth", kOk + ", lidar: { sensor: lidar, beam_width_deg: -1 } }", "beam_width_deg"},
        Refusal{"MixedTooOften", kOk + ", lidar: { sensor: lidar, mixed_probability: 1.5 } }", "mixed_probability"},
        Refusal{"SpinThatEndsBeforeItBegins", kOk + ", wheels: { sensor: wheels, track_m: 1, spins_s: [3, 2] } }",
                "spins_s"},
        Refusal{"NegativeJump", kOk + ", gps: { sensor: gps, jump_sigma_m: -1 } }", "jump_sigma_m"},
        Refusal{"NegativeJitter", kOk + ", gps: { sensor: gps, delay_jitter_s: -1 } }", "delay_jitter_s"},
        Refusal{"UnknownLawOfJitter", kOk + ", gps: { sensor: gps, delay_jitter_law: normal } }", "exponential"},
        Refusal{"MoreNanThanMeasurements", kOk + ", gps: { sensor: gps, nan_probability: 1.1 } }", "nan_probability"},
        Refusal{"DeathWithoutEnd", kOk + ", wheels: { sensor: wheels, track_m: 1, dead_s: [2] } }", "dead_s"},
        Refusal{"NegativeOutliers", kOk + ", gps: { sensor: gps, outlier_probability: -0.1 } }", "outlier_probability"},
        Refusal{"OutliersOfNoDistance", kOk + ", gps: { sensor: gps, outlier_max_m: 0 } }", "outlier_max_m"},
        Refusal{"FreezeThatEndsBeforeItBegins", kOk + ", gps: { sensor: gps, frozen_s: [3, 2] } }", "frozen_s"},
        Refusal{"ZeroSpeedNoise", kOk + ", gps: { sensor: gps, speed_sigma_mps: 0 } }", "speed_sigma_mps"},
        Refusal{"DisturbanceInNoFrame", kOk + ", magnetism: { disturbance_frame: robot }" + kWheels + "}", "base, map"},
        Refusal{"NoHorizontalField", kOk + ", magnetism: { earth_field_t: [0, 0, -4e-5] }" + kWheels + "}",
                "earth_field_t"},
        Refusal{"OddDisturbers", kOk + ", magnetism: { disturbers: [1, 2] }" + kWheels + "}", "disturbers"},
        Refusal{"OddWall", kOk + ", walls_m: [9, 9, 8]" + kWheels + "}", "walls_m"},
        Refusal{"WallWithoutLength", kOk + ", walls_m: [9, 9, 9, 9]" + kWheels + "}", "wall 1 has no length"},
        Refusal{"WallAcrossTheCourse", kOk + ", walls_m: [9, 9, 8, 9, 2, -3, 2, 3]" + kWheels + "}",
                "runs through wall 2"},
        Refusal{"TooMuchClutter", kOk + ", clutter: { stones: 200, area_m: [0, 0, 6, 6] }" + kWheels + "}",
                "of 200 fit"},
        Refusal{"HeightsUpsideDown", kOk + ", landmarks: { list_m: [2, 9, 1], height_m: [3, 2] }" + kWheels + "}",
                "height_m"},
        Refusal{"NoSuchTexture", kOk + ", landmarks: { list_m: [2, 9, 1], list_texture: [1] }" + kWheels + "}",
                "list_texture"},
        Refusal{"TextureForNoLandmark",
                kOk + ", landmarks: { list_m: [2, 9, 1], list_texture: [0, 0] }" + kWheels + "}", "2 textures for 1"},
        Refusal{"NoSuchMetal", kOk + ", landmarks: { list_m: [2, 9, 1], metal_textures: [3] }" + kWheels + "}",
                "metal_textures"},
        Refusal{"RingsUpsideDown",
                kOk + ", ground: false, lidar_3d: { sensor: lidar, elevation_min_deg: 5, elevation_max_deg: 4 } }",
                "elevation_max_deg: 4 is less than"},
        Refusal{"NoRing", kOk + ", lidar_3d: { sensor: lidar, rings: 0 } }", "rings"},
        Refusal{"TooManyBeams", kOk + ", lidar_3d: { sensor: lidar, rings: 1000, beams: 10000 } }",
                "at most 4000000 are expected"},
        Refusal{"ScannerInTheGround", kOk + ", lidar_3d: { sensor: lidar } }", "above the ground"},
        Refusal{"NegativeCeiling", kOk + ", ceiling_m: -1" + kWheels + "}", "ceiling_m"},
        Refusal{"ZeroNoiseOfTheCloud", kOk + ", lidar_3d: { sensor: lidar, sigma_m: 0 } }", "sigma_m"},
        Refusal{"OddBox", kOk + ", boxes_m: [9, 9, 1, 1]" + kWheels + "}", "boxes_m"},
        Refusal{"FlatBox", kOk + ", boxes_m: [9, 9, 1, 1, 0]" + kWheels + "}", "box 1 measures 1 x 1 x 0"},
        Refusal{"BoxOnTheCourse", kOk + ", boxes_m: [9, 9, 1, 1, 1, 2, 0.2, 1, 1, 1]" + kWheels + "}",
                "runs through box 2"},
        Refusal{"TooManyLandmarks", kOk + ", landmarks: { count: 100, area_m: [0, 0, 6, 6] }" + kWheels + "}",
                "of 100 landmarks fit"}),
    [](const auto& param_info) { return param_info.param.what; });

}  // namespace
}  // namespace waymark
