// SPDX-License-Identifier: Apache-2.0
// needs plugins: diagnostics, feature_map, kitti, landmarks, odometry, simulator, tum
// Without a camera image for a while, or with a useless one, the filter goes on, landmarks keep what is known of them,
// and diagnostics.json reports what happened.
#include <gmock/gmock.h>

#include <map>
#include <nlohmann/json.hpp>

#include "tests/system/outputs.hpp"
#include "tests/system/raw_recording.hpp"

namespace waymark::system_test {
namespace {

using testing::IsEmpty;

/// The figures of the map, and how many bad records the source had.
struct MapReport {
  explicit MapReport(const std::filesystem::path& out) {
    const auto report = nlohmann::json::parse(read_text(out / "diagnostics.json"));
    figures = report.at("landmarks").at(0).at("figures").get<std::map<std::string, double>>();
    steps = report.at("run").at("mapping_steps").get<double>();
    bad_records = report.at("run").at("bad_record_count").get<int>();
    events = report.at("run").at("events").size();
  }
  /// Every mapping step has one image or the lack of one.
  double images() const {
    double sum = 0.0;
    for (const auto& [name, value] : figures) sum += name.starts_with("images_") ? value : 0.0;
    return sum;
  }

  std::map<std::string, double> figures;
  double steps = 0.0;
  int bad_records = 0;
  std::size_t events = 0;
};

/// A row of landmarks.csv.
struct LandmarkRow {
  double x, y, radius, sightings;
};

std::vector<LandmarkRow> confirmed_landmarks(const std::filesystem::path& out) {
  std::vector<LandmarkRow> landmarks;
  const auto lines = lines_of(read_text(out / "landmarks.csv"));
  for (std::size_t i = 1; i < lines.size(); ++i) {
    std::vector<std::string> fields;
    std::istringstream in(lines[i]);
    for (std::string field; std::getline(in, field, ',');) fields.push_back(field);
    if (fields.at(11) == "1")
      landmarks.push_back({std::stod(fields[2]), std::stod(fields[3]), std::stod(fields[4]), std::stod(fields[10])});
  }
  return landmarks;
}

/// x at the end of the trajectory.
std::vector<double> last_row(const std::filesystem::path& trajectory) {
  std::istringstream in(lines_of(read_text(trajectory)).back());
  return {std::istream_iterator<double>(in), {}};
}

// --- the simulator: spans without image, with a black one, with a white one -----------------------------------------

const std::string kSimulation = R"(
source:
  plugin: simulator
  duration_s: 40
  course: { waypoints_m: [0, 0, 24, 0], laps: 1 }
  landmarks: { list_m: [4, 3, 0.2, 7, -3, 0.15, 11, 4, 0.25, 15, -4, 0.2, 19, 3, 0.15, 24, -4, 0.2, 28, 3, 0.25], textures: 3 }
  wheels: { sensor: wheels, rate_hz: 20, track_m: 0.5 }
  lidar: { sensor: lidar, rate_hz: 5, range_max_m: 15 }
  camera: { sensor: camera, rate_hz: 10 }
initial: { x_m: 0, y_m: 0, yaw_deg: 0 }
sensors:
  - { name: wheels, plugin: odometry, model: differential, track_m: 0.5 }
  - { name: camera, payload: Image, base_T_sensor: { xyz_m: [0.2, 0, 0.6] }, intrinsics: { size_px: [320, 120], focal_px: [160, 160], center_px: [159.5, 59.5] } }
  - { name: lidar, payload: LaserScan, base_T_sensor: { xyz_m: [0.2, 0, 0.5] } }
maps:
  - name: pillars
    plugin: feature_map
    inputs: [lidar, camera]
    attributes: [radius, signature]
    camera: { unseen: keep }     # or a pillar that only the scanner has seen is none yet
    extraction: { range_min_m: 0.2, range_max_m: 14.5, no_return_m: 15.5, segment_jump_m: 0.3, background_m: 0.8, width_max_m: 0.8 }
    existence: { view_range_m: 12, view_half_angle_deg: 130 }
filter: { particles: 10 }
sinks: [ { plugin: tum }, { plugin: landmarks }, { plugin: diagnostics } ]
)";

class SimulatedCameraLoss : public testing::Test {
 protected:
  std::filesystem::path run(const std::string& name, const std::vector<std::string>& settings) const {
    write_text(folder_ / "robot.yaml", kSimulation);
    std::vector<std::string> arguments{"run", (folder_ / "robot.yaml").string(), "--out", (folder_ / name).string()};
    for (const std::string& setting : settings) arguments.insert(arguments.end(), {"--set", setting});
    const Outcome outcome = waymark(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_THAT(outcome.errors(), IsEmpty());
    return folder_ / name;
  }
  static nlohmann::json score(const std::filesystem::path& out) {
    const Outcome outcome =
        waymark({"evaluate", "--json", "--estimate", (out / "trajectory.txt").string(), "--reference",
                 (out / "reference.txt").string(), "--landmarks", (out / "landmarks.csv").string(), "--survey",
                 (out / "reference_landmarks.csv").string()});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out);
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(SimulatedCameraLoss, TheFilterGoesOnAndTheCountsSayWhatHappened) {
  const auto out = run("faulty", {"source.camera.outages_s=[4, 8]", "source.camera.black_s=[11, 15]",
                                  "source.camera.overexposed_s=[18, 22]"});
  const MapReport reported(out);
  EXPECT_EQ(reported.events, 0U);
  EXPECT_EQ(reported.images(), reported.steps);
  // Four seconds at five scans a second; a span may begin or end between a scan and its image.
  EXPECT_NEAR(reported.figures.at("images_missing"), 20.0, 2.0);
  EXPECT_NEAR(reported.figures.at("images_dark"), 20.0, 2.0);
  EXPECT_NEAR(reported.figures.at("images_overexposed"), 20.0, 2.0);
  EXPECT_GE(reported.figures.at("images_used"), reported.steps - 66.0);
  EXPECT_EQ(reported.figures.at("images_undecodable"), 0.0);
  EXPECT_EQ(reported.figures.at("images_wrong_size"), 0.0);

  const nlohmann::json scored = score(out);
  EXPECT_LT(scored.at("trajectory").at("ate_max_m").get<double>(), 0.4) << scored.dump(1);
  EXPECT_GT(last_row(out / "trajectory.txt").at(0), 39.5);
}

TEST_F(SimulatedCameraLoss, LandmarksAreTheSameAsWithoutLoss) {
  const auto clean = run("clean", {});
  EXPECT_EQ(MapReport(clean).figures.at("images_used"), MapReport(clean).steps);
  const auto good = score(clean).at("landmarks");
  ASSERT_EQ(good.at("matched").get<int>(), 7) << good.dump(1);
  for (const std::string fault : {"outages_s", "black_s", "overexposed_s"}) {
    SCOPED_TRACE(fault);
    const auto out = run(fault, {"source.camera." + fault + "=[10, 20]"});
    EXPECT_LE(MapReport(out).figures.at("images_used"), MapReport(out).steps - 48.0);
    const auto scored = score(out).at("landmarks");
    EXPECT_EQ(scored.at("matched").get<int>(), 7) << scored.dump(1);
    EXPECT_EQ(scored.at("duplicates").get<int>(), 0) << scored.dump(1);
    EXPECT_LT(scored.at("radius_rms_m").get<double>(), good.at("radius_rms_m").get<double>() + 0.02);
  }
}

// --- a raw recording of KITTI's kind: files that are no images, of another size, black, white, missing ---------------

class RecordedCameraLoss : public testing::Test {
 protected:
  std::filesystem::path run(const std::string& name) const {
    const Outcome outcome =
        waymark({"run", recording_.yaml().string(), "--out", (recording_.folder() / name).string()});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_THAT(outcome.errors(), IsEmpty());
    return recording_.folder() / name;
  }
  /// All poles are there, each seen in so many scans, with its own radius.
  static void expect_poles(const std::filesystem::path& out, int scans) {
    const auto landmarks = confirmed_landmarks(out);
    ASSERT_EQ(landmarks.size(), RawRecording::kPoles.size());
    for (const auto& pole : RawRecording::kPoles) {
      const auto found = std::ranges::find_if(
          landmarks, [&](const LandmarkRow& l) { return std::hypot(l.x - pole.x, l.y - pole.y) < 0.1; });
      ASSERT_NE(found, landmarks.end()) << "no landmark at " << pole.x << ", " << pole.y;
      EXPECT_NEAR(found->radius, pole.radius, 0.03);
      EXPECT_EQ(found->sightings, scans);
    }
    EXPECT_NEAR(last_row(out / "trajectory.txt").at(1), RawRecording::x_at(RawRecording::kFrames - 1), 0.03);
  }

  RawRecording recording_;
};

TEST_F(RecordedCameraLoss, WithoutFaultsEveryImageIsUsed) {
  recording_.write();
  const auto out = run("out");
  const MapReport reported(out);
  EXPECT_EQ(reported.steps, RawRecording::kFrames);
  EXPECT_EQ(reported.figures.at("images_used"), RawRecording::kFrames);
  EXPECT_EQ(reported.figures.at("candidates_no_edges"), 0.0);
  EXPECT_EQ(reported.bad_records, 0);
  expect_poles(out, RawRecording::kFrames);
}

TEST_F(RecordedCameraLoss, UselessImagesCostNothingButThemselves) {
  recording_.write();
  const std::string picture = read_text(recording_.image(4));
  write_text(recording_.image(4), "this is no image");
  write_text(recording_.image(5), picture.substr(0, 40));
  recording_.write_image(6, RawRecording::kWidth, RawRecording::kHeight - 1);
  recording_.write_image(7, RawRecording::kHeight, RawRecording::kWidth);
  recording_.write_image(8, RawRecording::kWidth, RawRecording::kHeight, 0.0);
  recording_.write_image(9, RawRecording::kWidth, RawRecording::kHeight, 100.0);
  std::filesystem::remove(recording_.image(10));
  write_text(recording_.cloud(11), "abc");

  const auto out = run("out");
  const MapReport reported(out);
  EXPECT_EQ(reported.events, 0U);
  EXPECT_EQ(reported.steps, RawRecording::kFrames - 1);
  EXPECT_EQ(reported.images(), reported.steps);
  EXPECT_EQ(reported.figures.at("images_undecodable"), 2.0);
  EXPECT_EQ(reported.figures.at("images_wrong_size"), 2.0);
  EXPECT_EQ(reported.figures.at("images_dark"), 1.0);
  EXPECT_EQ(reported.figures.at("images_overexposed"), 1.0);
  EXPECT_EQ(reported.figures.at("images_missing"), 1.0);
  EXPECT_EQ(reported.figures.at("images_used"), RawRecording::kFrames - 8);
  EXPECT_EQ(reported.bad_records, 2);
  expect_poles(out, RawRecording::kFrames - 1);
}

TEST_F(RecordedCameraLoss, OneBadFileTooManyStopsTheRunAndNamesIt) {
  recording_.write();
  for (const int frame : {10, 12, 14}) std::filesystem::remove(recording_.image(frame));
  const Outcome outcome = waymark({"run", recording_.yaml().string(), "--out", (recording_.folder() / "out").string()});
  EXPECT_TRUE(
      reports_error(outcome, 1, {recording_.image(14).filename().string(), "is missing", "max_bad_records allows 2"}));
  EXPECT_EQ(MapReport(recording_.folder() / "out").steps, 14) << "what came before is kept";
}

}  // namespace
}  // namespace waymark::system_test
