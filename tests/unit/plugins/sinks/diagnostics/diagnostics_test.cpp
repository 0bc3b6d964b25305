// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "unit/plugins/sinks/fake_snapshot.hpp"

namespace waymark {
namespace {

using test::FakeSnapshot;
using test::make_sink;
using test::TemporaryFolder;

class DiagnosticsSink : public ::testing::Test {
 protected:
  DiagnosticsSink() { sink_->start({out_.path(), nullptr, nullptr}); }

  nlohmann::json finish(const Snapshot* last, const RunReport& report) {
    sink_->finish(last, report);
    return nlohmann::json::parse(out_.read("diagnostics.json"));
  }

  /// One snapshot per second.
  void write(int count) {
    FakeSnapshot snapshot;
    for (int i = 0; i < count; ++i) {
      snapshot.effective_sample_size_ = 10.0 + i % 5;
      snapshot.pose_variance(0.04, 0.09, 0.0001).at(i, Pose());
      sink_->write(snapshot);
    }
  }

  TemporaryFolder out_;
  std::shared_ptr<Sink> sink_ = make_sink("diagnostics");
};

TEST_F(DiagnosticsSink, ReportsEachSensor) {
  RunReport report;
  SensorReport& gps = report.sensors.emplace_back();
  gps.name = "gps";
  gps.plugin = "dgps";
  gps.measurements = 51;
  gps.fused = 40;
  gps.gated = 3;
  gps.held_out = 2;
  gps.late = 1;
  gps.before_start = 4;
  gps.unusable = 1;
  gps.processed_late = 7;
  gps.mistimed = 2;
  gps.first = Time{from_seconds(100.0)};
  gps.last = Time{from_seconds(110.0)};
  gps.latency_max_s = 0.25;
  gps.nis_sum = 86.0;
  gps.nis_count = 43;
  gps.nis_dof = 86;
  const auto sensor = finish(nullptr, report)["sensors"][0];
  EXPECT_EQ(sensor["name"], "gps");
  EXPECT_EQ(sensor["plugin"], "dgps");
  EXPECT_EQ(sensor["measurements"], 51);
  EXPECT_DOUBLE_EQ(sensor["rate_hz"].get<double>(), 5.0);
  EXPECT_EQ(sensor["fused"], 40);
  EXPECT_EQ(sensor["gated"], 3);
  EXPECT_EQ(sensor["held_out"], 2);
  EXPECT_EQ(sensor["late"], 1);
  EXPECT_EQ(sensor["before_start"], 4);
  EXPECT_EQ(sensor["unusable"], 1);
  EXPECT_EQ(sensor["processed_late"], 7);
  EXPECT_EQ(sensor["mistimed"], 2);
  EXPECT_DOUBLE_EQ(sensor["latency_max_s"].get<double>(), 0.25);
  EXPECT_DOUBLE_EQ(sensor["mean_nis"].get<double>(), 2.0);
  EXPECT_DOUBLE_EQ(sensor["expected_nis"].get<double>(), 2.0);
}

TEST_F(DiagnosticsSink, TellsWhenTheHealthChangedAndHowLongItWasWhat) {
  RunReport report;
  report.sensors.resize(1);
  report.sensors[0].name = "gps";
  FakeSnapshot snapshot;
  snapshot.health_.sensors.resize(1);
  constexpr int kBegin = -100;  // some logs count from an event
  for (int k = 0; k < 10; ++k) {
    const int t = kBegin + k;
    const bool silent = k >= 4 && k < 7;
    snapshot.health_.state = silent ? Health::State::degraded : Health::State::ok;
    snapshot.health_.reason = silent ? "gps is silent: has stopped" : "";
    snapshot.health_.sensors[0].state = silent ? SensorHealth::State::silent : SensorHealth::State::ok;
    snapshot.health_.sensors[0].reason = silent ? "has stopped" : "";
    sink_->write(snapshot.at(t, Pose()));
  }
  report.health = {.ok_s = 6.0, .degraded_s = 3.0, .lost_s = 0.0};
  const auto health = finish(nullptr, report)["health"];
  EXPECT_DOUBLE_EQ(health["ok_s"].get<double>(), 6.0);
  EXPECT_DOUBLE_EQ(health["degraded_s"].get<double>(), 3.0);
  EXPECT_DOUBLE_EQ(health["lost_s"].get<double>(), 0.0);
  ASSERT_EQ(health["changes"].size(), 4u);
  EXPECT_EQ(health["changes"][0]["of"], "all");
  EXPECT_EQ(health["changes"][0]["t_s"], kBegin + 4.0);
  EXPECT_EQ(health["changes"][0]["reason"], "gps is silent: has stopped");
  EXPECT_EQ(health["changes"][1]["of"], "gps");
  EXPECT_EQ(health["changes"][1]["state"], "silent");
  EXPECT_EQ(health["changes"][3]["state"], "ok");
}

TEST_F(DiagnosticsSink, ASensorThatSaidNothingHasNoRateAndNoNis) {
  RunReport report;
  report.sensors.resize(1);
  const auto document = finish(nullptr, report);
  EXPECT_TRUE(document["sensors"][0]["rate_hz"].is_null());
  EXPECT_TRUE(document["sensors"][0]["mean_nis"].is_null());
  EXPECT_TRUE(document["sensors"][0]["expected_nis"].is_null());
  EXPECT_TRUE(document["run"]["duration_s"].is_null());
}

TEST_F(DiagnosticsSink, ReportsTheRun) {
  RunReport report;
  report.sensors.resize(3);
  report.sensors[0].measurements = report.sensors[1].measurements = 2;
  report.sensors[0].first = Time{from_seconds(5.0)};
  report.sensors[0].last = Time{from_seconds(8.0)};
  report.sensors[1].first = Time{from_seconds(4.0)};
  report.sensors[1].last = Time{from_seconds(7.0)};
  report.interrupted = true;
  report.mapping_steps = 17;
  report.resamplings = 4;
  report.events.push_back({"plugin 'x' is out of service", Time{from_seconds(6.5)}});
  const auto run = finish(nullptr, report)["run"];
  EXPECT_EQ(run["interrupted"], true);
  EXPECT_DOUBLE_EQ(run["duration_s"].get<double>(), 4.0);
  EXPECT_EQ(run["mapping_steps"], 17);
  EXPECT_EQ(run["resamplings"], 4);
  EXPECT_EQ(run["events"][0]["text"], "plugin 'x' is out of service");
  EXPECT_DOUBLE_EQ(run["events"][0]["t_s"].get<double>(), 6.5);
}

TEST_F(DiagnosticsSink, WritesStampsToTheNanosecond) {
  RunReport report;
  report.events.push_back({"at its time", Time{Duration{1777640429070000123}}});
  report.events.push_back({"with few digits", Time{Duration{1777640429070000000}}});
  report.events.push_back({"before the epoch", Time{Duration{-1500000000}}});
  FakeSnapshot snapshot;
  snapshot.belief_.stamp = Time{Duration{1777640429000000001}};
  sink_->write(snapshot);
  finish(nullptr, report);
  const std::string text = out_.read("diagnostics.json");
  EXPECT_THAT(text, ::testing::HasSubstr("\"t_s\": 1777640429.070000123,"));
  EXPECT_THAT(text, ::testing::HasSubstr("\"t_s\": 1777640429.07,"));
  EXPECT_THAT(text, ::testing::HasSubstr("\"t_s\": -1.5,"));
  EXPECT_THAT(text, ::testing::HasSubstr("1777640429.000000001,\n"));
}

TEST_F(DiagnosticsSink, ListsTheFirstHundredBadRecords) {
  RunReport report;
  for (int i = 1; i <= 130; ++i) report.bad_records.push_back({"log.csv:" + std::to_string(i), "too few columns"});
  const auto run = finish(nullptr, report)["run"];
  EXPECT_EQ(run["bad_record_count"], 130);
  ASSERT_EQ(run["bad_records"].size(), 100u);
  EXPECT_EQ(run["bad_records"][99]["place"], "log.csv:100");
  EXPECT_EQ(run["bad_records"][99]["reason"], "too few columns");
}

TEST_F(DiagnosticsSink, SurvivesBytesThatAreNoText) {
  RunReport report;
  report.bad_records.push_back({"log.csv:1", "\xff\xfe is not a number"});
  EXPECT_EQ(finish(nullptr, report)["run"]["bad_record_count"], 1);
}

TEST_F(DiagnosticsSink, ReportsTheEffectiveSampleSize) {
  write(5);
  const auto n_eff = finish(nullptr, {})["effective_sample_size"];
  EXPECT_DOUBLE_EQ(n_eff["min"].get<double>(), 10.0);
  EXPECT_DOUBLE_EQ(n_eff["median"].get<double>(), 12.0);
  ASSERT_EQ(n_eff["over_time"].size(), 5u);
  EXPECT_EQ(n_eff["over_time"][3], nlohmann::json::parse("[3.0, 13.0]"));
}

TEST_F(DiagnosticsSink, TheSmallestSampleSizeIsFoundAlsoBetweenTheRowsKept) {
  FakeSnapshot snapshot;
  for (int i = 0; i < 4000; ++i) {
    snapshot.effective_sample_size_ = i == 3333 ? 2.0 : 20.0;
    sink_->write(snapshot.at(i, Pose()));
  }
  EXPECT_DOUBLE_EQ(finish(nullptr, {})["effective_sample_size"]["min"].get<double>(), 2.0);
}

TEST_F(DiagnosticsSink, ThinsALongRunEvenly) {
  write(12345);
  const auto document = finish(nullptr, {});
  for (const char* series : {"effective_sample_size", "pose_sigma"}) {
    const auto& rows = document[series]["over_time"];
    ASSERT_LE(rows.size(), 500u);
    ASSERT_GE(rows.size(), 250u);
    const double step = rows[1][0].get<double>() - rows[0][0].get<double>();
    for (std::size_t i = 0; i < rows.size(); ++i) {
      EXPECT_DOUBLE_EQ(rows[i][0].get<double>(), static_cast<double>(i) * step);
    }
    EXPECT_GT(rows.back()[0].get<double>(), 12345.0 - 1.0 - step);
  }
}

TEST_F(DiagnosticsSink, ReportsTheUncertaintyOfThePose) {
  write(1);
  const auto row = finish(nullptr, {})["pose_sigma"]["over_time"][0];
  EXPECT_NEAR(row[1].get<double>(), 0.2, 1e-12);
  EXPECT_NEAR(row[2].get<double>(), 0.3, 1e-12);
  EXPECT_NEAR(row[3].get<double>(), 0.01, 1e-12);
}

TEST_F(DiagnosticsSink, WritesNullForWhatIsNotFinite) {
  FakeSnapshot snapshot;
  snapshot.effective_sample_size_ = std::numeric_limits<double>::quiet_NaN();
  snapshot.pose_variance(std::numeric_limits<double>::infinity(), 0.0, 0.0);
  sink_->write(snapshot);
  const auto document = finish(&snapshot, {});
  EXPECT_TRUE(document["effective_sample_size"]["min"].is_null());
  EXPECT_TRUE(document["effective_sample_size"]["median"].is_null());
  EXPECT_TRUE(document["effective_sample_size"]["over_time"][0][1].is_null());
  EXPECT_TRUE(document["pose_sigma"]["over_time"][0][1].is_null());
}

TEST_F(DiagnosticsSink, CountsLandmarksAndParticlesAtTheEnd) {
  FakeSnapshot snapshot;
  snapshot.particles_.resize(25);
  snapshot.maps_ = {{"trees", std::vector<LandmarkView>(5)}};
  snapshot.maps_[0].landmarks[1].confirmed = snapshot.maps_[0].landmarks[4].confirmed = true;
  const auto document = finish(&snapshot, {});
  EXPECT_EQ(document["particles"], 25);
  EXPECT_EQ(document["landmarks"][0]["map"], "trees");
  EXPECT_EQ(document["landmarks"][0]["confirmed"], 2);
  EXPECT_EQ(document["landmarks"][0]["provisional"], 3);
}

TEST_F(DiagnosticsSink, ShowsTheFiguresOfEachMap) {
  FakeSnapshot snapshot;
  snapshot.maps_ = {{"trees", {}}, {"walls", {}}};
  snapshot.maps_[0].figures = {{"merged", 3.0}, {"share", 0.25}};
  const auto document = finish(&snapshot, {});
  EXPECT_EQ(document["landmarks"][0]["figures"]["merged"], 3.0);
  EXPECT_EQ(document["landmarks"][0]["figures"]["share"], 0.25);
  EXPECT_TRUE(document["landmarks"][1]["figures"].empty());
}

TEST_F(DiagnosticsSink, WritesTheFiguresOfTheMapsOverTime) {
  sink_ = make_sink("diagnostics", "map_figures_every_s: 5");
  sink_->start({out_.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  snapshot.started_ = false;
  sink_->write(snapshot.at(0, Pose()));
  snapshot.started_ = true;
  snapshot.maps_ = {{"trees", {}}, {"a \"b\", c", {}}};
  for (int t = 1; t <= 13; ++t) {
    snapshot.maps_[0].figures = {{"merged", 1.0 * t},
                                 {"share", t == 6 ? std::numeric_limits<double>::quiet_NaN() : 0.25}};
    snapshot.maps_[1].figures = {{"memory_bytes", 1e6}};
    sink_->write(snapshot.at(t, Pose()));
  }
  sink_->finish(&snapshot, {});
  std::string expected = "t_s,map,figure,value\n";
  for (const auto& [time, merged, share] : {std::array{"1", "1", "0.25"}, std::array{"6", "6", ""},
                                            std::array{"11", "11", "0.25"}, std::array{"13", "13", "0.25"}}) {
    const std::string t = std::string(time) + ".000000000,";
    expected += t + "trees,merged," + merged + "\n" + t + "trees,share," + share + "\n" + t +
                "\"a \"\"b\"\", c\",memory_bytes,1000000\n";
  }
  EXPECT_EQ(out_.read("map_figures.csv"), expected);
}

TEST_F(DiagnosticsSink, WritesNoFiguresOverTimeUnlessAsked) {
  write(20);
  finish(nullptr, {});
  EXPECT_FALSE(std::filesystem::exists(out_.path() / "map_figures.csv"));
}

TEST_F(DiagnosticsSink, TheFiguresOverTimeNeedAFileOfTheirOwn) {
  EXPECT_THROW(make_sink("diagnostics", "map_figures_file: diagnostics.json"), ConfigError);
}

TEST_F(DiagnosticsSink, EqualRunsGiveEqualBytes) {
  write(1234);
  sink_->finish(nullptr, {});
  const std::string first = out_.read("diagnostics.json");
  sink_ = make_sink("diagnostics");
  sink_->start({out_.path(), nullptr, nullptr});
  write(1234);
  sink_->finish(nullptr, {});
  EXPECT_EQ(out_.read("diagnostics.json"), first);
}

}  // namespace
}  // namespace waymark
