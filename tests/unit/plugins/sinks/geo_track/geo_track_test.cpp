// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "plugins/sinks/geo_track/track.hpp"
#include "unit/plugins/sinks/fake_snapshot.hpp"
#include "waymark/base/error.hpp"

namespace waymark {
namespace {

using test::FakeSnapshot;
using test::make_sink;
using test::TemporaryFolder;
using testing::HasSubstr;

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

class GeoTrackSink : public testing::Test {
 protected:
  /// Drives east for 3 s, loses the pose, and goes on.
  void run(std::string_view yaml = "{}") {
    const auto sink = make_sink("geo_track", yaml);
    sink->start({out_.path(), nullptr, nullptr});
    snapshot_.datum_ = Datum{49.0, 8.4, 110.0};
    for (int i = 0; i <= 30; ++i) sink->write(snapshot_.at(0.1 * i, Pose::planar(0.1 * i, 0.0, 0.0)));
    snapshot_.started_ = false;
    sink->write(snapshot_);
    snapshot_.started_ = true;
    sink->write(snapshot_.at(10.0, Pose::planar(20.0, 0.0, 0.0)));
    sink->finish(&snapshot_, {});
  }
  TemporaryFolder out_;
  FakeSnapshot snapshot_;
};

TEST_F(GeoTrackSink, WritesTheTrackInPiecesWithItsTimes) {
  run();
  const auto document = nlohmann::json::parse(text_of(out_ / "track.geojson"));
  const auto& track = document.at("features").at(0);
  EXPECT_EQ(track.at("geometry").at("coordinates").size(), 2u) << "the pose was lost in between";
  EXPECT_EQ(track.at("geometry").at("coordinates").at(0).size(), 4u) << "a point every second";
  EXPECT_EQ(track.at("geometry").at("coordinates").at(0).at(0), nlohmann::json({8.4, 49.0, 110.0}));
  EXPECT_EQ(track.at("properties").at("times").at(0).at(1), "1970-01-01T00:00:01.000Z");
  EXPECT_THAT(
      text_of(out_ / "track.gpx"),
      HasSubstr("<trkpt lat=\"49.00000000\" lon=\"8.40000000\"><ele>110.000</ele><time>1970-01-01T00:00:00.000Z"));
  EXPECT_THAT(text_of(out_ / "track.kml"), HasSubstr("8.40000000,49.00000000,110.000\n"));
}

TEST_F(GeoTrackSink, WritesConfirmedLandmarks) {
  LandmarkView confirmed;
  confirmed.id = 7;
  confirmed.confirmed = true;
  LandmarkView provisional;
  snapshot_.maps_ = {MapDescription{"a<b", {confirmed, provisional}}};
  run();
  EXPECT_THAT(text_of(out_ / "track.gpx"),
              HasSubstr("<wpt lat=\"49.00000000\" lon=\"8.40000000\"><name>a&lt;b 7</name>"));
  EXPECT_EQ(nlohmann::json::parse(text_of(out_ / "track.geojson")).at("features").size(), 2u);
}

TEST_F(GeoTrackSink, LeavesOutWhatIsNotWanted) {
  run("{gpx: none, kml: none}");
  EXPECT_FALSE(std::filesystem::exists(out_ / "track.gpx"));
  EXPECT_FALSE(std::filesystem::exists(out_ / "track.kml"));
  EXPECT_TRUE(std::filesystem::exists(out_ / "track.geojson"));
}

TEST_F(GeoTrackSink, WithoutADatumItFails) {
  const auto sink = make_sink("geo_track");
  sink->start({out_.path(), nullptr, nullptr});
  sink->write(snapshot_);
  EXPECT_THROW(sink->finish(&snapshot_, {}), Error);
}

TEST(ThinnedPath, HasABoundedNumberOfPointsAndKeepsBeginnings) {
  geo_track::ThinnedPath path(Duration::zero(), 100);
  for (int i = 0; i < 10'000; ++i) {
    if (i == 5'000) path.interrupt();
    path.add(Time{from_seconds(0.01 * i)}, {0.1 * i, 0.0, 0.0});
  }
  const auto pieces = path.pieces({49.0, 8.4, 0.0});
  ASSERT_EQ(pieces.size(), 2u);
  EXPECT_LT(pieces[0].size() + pieces[1].size(), 100u);
  EXPECT_EQ(pieces[1].front().stamp, Time{from_seconds(50.0)});
}

}  // namespace
}  // namespace waymark
