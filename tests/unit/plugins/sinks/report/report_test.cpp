// SPDX-License-Identifier: Apache-2.0
// needs plugins: report
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "report_document.hpp"
#include "unit/plugins/sinks/fake_snapshot.hpp"
#include "waymark/base/error.hpp"

namespace waymark {
namespace {

using nlohmann::json;
using test::FakeSnapshot;
using test::make_sink;
using test::TemporaryFolder;
using ::testing::HasSubstr;
using ::testing::Not;

class ReportSink : public ::testing::Test {
 protected:
  /// The document within the page.
  json data(const std::string& file = "report.html") const { return test::report_document(out_.read(file)); }

  RunInfo info(std::shared_ptr<const Reference> reference = nullptr) const {
    return {out_.path(), nullptr, std::move(reference), "filter: { seed: 1 }\n", "robot"};
  }

  static void wheel(FakeSnapshot& snapshot, double t, Sink& sink) {
    snapshot.measurement_.payload = std::make_shared<WheelSpeeds>();
    snapshot.measurement_.sensor = 0;
    sink.write(snapshot.at(t, Pose::planar(t, 0.0, 0.0)));
  }

  static void fix(FakeSnapshot& snapshot, double t, const GnssFix& fix, Fate fate, Sink& sink) {
    snapshot.measurement_.payload = std::make_shared<GnssFix>(fix);
    snapshot.measurement_.sensor = 1;
    snapshot.fate_ = fate;
    sink.write(snapshot.at(t, Pose::planar(t, 0.0, 0.0)));
    snapshot.fate_ = Fate::fused;
  }

  static RunReport two_sensors() {
    RunReport report;
    report.sensors.resize(2);
    report.sensors[0].name = "wheels";
    report.sensors[1].name = "gps";
    return report;
  }

  TemporaryFolder out_;
};

TEST_F(ReportSink, IsOnePageThatNeedsNoNetwork) {
  const auto sink = make_sink("report");
  sink->start(info());
  FakeSnapshot snapshot;
  wheel(snapshot, 0.0, *sink);
  sink->finish(&snapshot, {});
  const std::string page = out_.read("report.html");
  EXPECT_THAT(page, HasSubstr("uPlot"));
  EXPECT_THAT(page, Not(HasSubstr("src=\"http")));
  EXPECT_THAT(page, Not(HasSubstr("{{")));
  EXPECT_EQ(data()["name"], "robot");
  EXPECT_EQ(data()["config"], "filter: { seed: 1 }\n");
}

TEST_F(ReportSink, TextsOfTheLogCannotEndItsData) {
  const auto sink = make_sink("report");
  sink->start(info());
  FakeSnapshot snapshot;
  wheel(snapshot, 0.0, *sink);
  RunReport report;
  report.notices = {"</script><script>alert(1)</script>", "not UTF-8: \xff"};
  sink->finish(&snapshot, report);
  EXPECT_EQ(data()["notices"][0], "</script><script>alert(1)</script>");
  EXPECT_THAT(out_.read("report.html"), Not(HasSubstr("<script>alert")));
}

TEST_F(ReportSink, PlacesGeodeticFixesWithTheDatum) {
  const auto sink = make_sink("report");
  sink->start(info());
  FakeSnapshot snapshot;
  snapshot.datum_ = Datum{49.0, 8.0, 100.0};
  GnssFix geodetic;
  geodetic.latitude_deg = 49.001;  // 111.2 m to the north
  geodetic.longitude_deg = 8.0;
  fix(snapshot, 1.0, geodetic, Fate::held_out, *sink);
  GnssFix local;
  local.p_map_antenna = {3.0, 4.0, 0.0};
  fix(snapshot, 2.0, local, Fate::gated, *sink);
  sink->finish(&snapshot, two_sensors());
  const json fixes = data()["fixes"];
  ASSERT_EQ(fixes[2]["kind"], "held out");
  EXPECT_NEAR(fixes[2]["x"][0].get<double>(), 0.0, 0.001);
  EXPECT_NEAR(fixes[2]["y"][0].get<double>(), 111.2, 0.1);
  ASSERT_EQ(fixes[1]["kind"], "rejected");
  EXPECT_EQ(fixes[1]["x"][0], 3.0);
  EXPECT_EQ(fixes[0]["count"], 0);
}

TEST_F(ReportSink, ReportsAnOutageAndNoUsualGap) {
  const auto sink = make_sink("report");
  sink->start(info());
  FakeSnapshot snapshot;
  GnssFix local;
  local.p_map_antenna = {0.0, 0.0, 0.0};
  for (int i = 0; i <= 60; ++i) {
    const double t = 0.5 * i;
    if (t > 10.0 && t < 22.0) continue;
    fix(snapshot, t, local, Fate::fused, *sink);
  }
  sink->finish(&snapshot, two_sensors());
  const json outages = data()["outages"];
  ASSERT_EQ(outages.size(), 1);
  EXPECT_EQ(outages[0]["sensor"], "gps");
  EXPECT_EQ(outages[0]["from"], 10.0);
  EXPECT_EQ(outages[0]["to"], 22.0);
}

TEST_F(ReportSink, ASensorThatOnlyPlacesTheMapHasNoOutage) {
  const auto sink = make_sink("report");
  sink->start(info());
  FakeSnapshot snapshot;
  GnssFix local;
  local.p_map_antenna = {0.0, 0.0, 0.0};
  fix(snapshot, 0.0, local, Fate::fused, *sink);
  for (int i = 1; i <= 60; ++i) fix(snapshot, i, local, Fate::held_out, *sink);
  sink->finish(&snapshot, two_sensors());
  EXPECT_TRUE(data()["outages"].empty());
}

TEST_F(ReportSink, ThinsALongRunEvenlyAndKeepsItsEnds) {
  const auto sink = make_sink("report");
  sink->start(info());
  FakeSnapshot snapshot;
  constexpr int kCount = 100'000;
  for (int i = 0; i <= kCount; ++i) wheel(snapshot, 0.1 * i, *sink);
  sink->finish(&snapshot, two_sensors());
  const std::vector<double> t = data()["track"]["t"];
  EXPECT_LE(t.size(), 8192);
  EXPECT_GE(t.size(), 4000);
  EXPECT_EQ(t.front(), 0.0);
  EXPECT_EQ(t.back(), 0.1 * kCount);
  double longest = 0.0;
  for (std::size_t i = 1; i < t.size(); ++i) longest = std::max(longest, t[i] - t[i - 1]);
  EXPECT_LT(longest, 4 * 0.1 * kCount / static_cast<double>(t.size()));
}

TEST_F(ReportSink, SumsOfTheNisSurviveThinning) {
  const auto sink = make_sink("report");
  sink->start(info());
  FakeSnapshot snapshot;
  constexpr int kCount = 5000;
  for (int i = 1; i <= kCount; ++i) {
    snapshot.counters_.fused = static_cast<std::uint64_t>(i);
    snapshot.counters_.nis_sum = 2.0 * i;
    snapshot.counters_.nis_dof = static_cast<std::uint64_t>(2 * i);
    wheel(snapshot, 0.1 * i, *sink);
  }
  sink->finish(&snapshot, two_sensors());
  const json wheels = data()["sensor_series"]["sensors"][0];
  EXPECT_LE(wheels["nis"].size(), 1024);
  EXPECT_EQ(wheels["nis"].back(), 2.0 * kCount);
  EXPECT_EQ(wheels["dof"].back(), 2 * kCount);
  for (std::size_t i = 0; i < wheels["nis"].size(); ++i) EXPECT_EQ(wheels["nis"][i], wheels["dof"][i]);
}

TEST_F(ReportSink, TheDateIsThatOfTheLog) {
  const auto sink = make_sink("report");
  sink->start(info());
  FakeSnapshot snapshot;
  wheel(snapshot, 1317042120.0, *sink);
  sink->finish(&snapshot, {});
  EXPECT_EQ(data()["date"], "2011-09-26 13:02 UTC");
}

TEST_F(ReportSink, ALogWithoutAStartHasAPage) {
  const auto sink = make_sink("report", "{file: other.html}");
  sink->start(info());
  FakeSnapshot snapshot;
  snapshot.started_ = false;
  wheel(snapshot, 0.0, *sink);
  sink->finish(&snapshot, {});
  EXPECT_EQ(data("other.html")["started"], false);
}

TEST_F(ReportSink, FindingsAreInTheDocument) {
  const auto sink = make_sink("report");
  sink->start(info());
  FakeSnapshot snapshot;
  wheel(snapshot, 0.0, *sink);
  RunReport report;
  report.findings = {{Finding::Certainty::named,
                      "yaw rate",
                      {"wheels"},
                      "1.13 times that of gps",
                      "track_m: 0.56",
                      12.0,
                      Time{} + std::chrono::seconds(3)}};
  sink->finish(&snapshot, report);
  const json finding = data()["findings"][0];
  EXPECT_EQ(finding["sensors"][0], "wheels");
  EXPECT_EQ(finding["text"], "1.13 times that of gps");
  EXPECT_EQ(finding["suggestion"], "track_m: 0.56");
  EXPECT_EQ(finding["t"], 3.0);
}

TEST_F(ReportSink, RefusesAFileThatABrowserDoesNotOpen) {
  EXPECT_THROW(make_sink("report", "{file: report.txt}"), ConfigError);
}

}  // namespace
}  // namespace waymark
