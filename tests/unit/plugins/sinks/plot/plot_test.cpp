// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "unit/plugins/sinks/fake_snapshot.hpp"
#include "waymark/base/error.hpp"

namespace waymark {
namespace {

using test::FakeSnapshot;
using test::make_sink;
using test::TemporaryFolder;

class PlotSink : public ::testing::Test {
 protected:
  // A drive along a square's two sides past one landmark in the middle of the map.
  static void drive(Sink& sink, FakeSnapshot& snapshot, bool landmark = true) {
    for (int i = 0; i <= 40; ++i) {
      const double along = 0.5 * i;
      snapshot.at(0.1 * i, i <= 20 ? Pose::planar(along - 5, -5, 0) : Pose::planar(5, along - 15, 1.57));
      snapshot.pose_variance(0.01, 0.02, 0.001);
      sink.write(snapshot);
    }
    snapshot.particles_ = {{snapshot.belief_.mean.T_map_base, 1.0}};
    if (!landmark) return;
    LandmarkView view;
    view.id = 3;
    view.p_map = {0.0, 0.0};
    view.radius_m = 0.5;
    view.P = Eigen::Vector3d(0.01, 0.01, 0.001).asDiagonal();
    view.confirmed = true;
    snapshot.maps_ = {{"trees", {view}}};
  }

  cv::Mat picture(const std::string& file = "map.png") const {
    const std::string bytes = out_.read(file);
    return cv::imdecode(cv::Mat(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data())),
                        cv::IMREAD_COLOR);
  }

  // Pixels of a box around the middle of the map that differ from white by more than the grid does.
  static int marked(const cv::Mat& image, const cv::Rect& box) {
    int count = 0;
    for (int y = box.y; y < box.y + box.height; ++y) {
      for (int x = box.x; x < box.x + box.width; ++x) {
        const auto& p = image.at<cv::Vec3b>(y, x);
        count += std::min({p[0], p[1], p[2]}) < 200 ? 1 : 0;
      }
    }
    return count;
  }

  TemporaryFolder out_;
};

// The map's area at 800 × 600, from the layout: left 39, top 36, right 635, bottom 571.
constexpr int kMiddleX = 337;
constexpr int kMiddleY = 303;

TEST_F(PlotSink, WritesAPictureOfTheSizeAskedFor) {
  const auto sink = make_sink("plot", "{width_px: 800, height_px: 600, file: run.png}");
  sink->start({out_.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  drive(*sink, snapshot);
  sink->finish(&snapshot, {});
  const cv::Mat image = picture("run.png");
  EXPECT_EQ(image.cols, 800);
  EXPECT_EQ(image.rows, 600);
}

TEST_F(PlotSink, IsOfStandardSizeByDefault) {
  const auto sink = make_sink("plot");
  sink->start({out_.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  drive(*sink, snapshot);
  sink->finish(&snapshot, {});
  EXPECT_EQ(picture().size(), cv::Size(1600, 1200));
}

TEST_F(PlotSink, DrawsALandmarkWhereItIs) {
  const cv::Rect around(kMiddleX - 8, kMiddleY - 8, 16, 16);
  for (const bool landmark : {false, true}) {
    const auto sink = make_sink("plot", "{width_px: 800, height_px: 600, landmark_labels: off}");
    sink->start({out_.path(), nullptr, nullptr});
    FakeSnapshot snapshot;
    drive(*sink, snapshot, landmark);
    sink->finish(&snapshot, {});
    const int count = marked(picture(), around);
    EXPECT_EQ(count > 0, landmark) << count << " marked pixels";
    // 0.5 m at 43 px per metre covers the whole box.
    if (landmark) {
      EXPECT_GT(count, 200);
    }
  }
}

TEST_F(PlotSink, DrawsTheReferenceInRed) {
  const auto sink = make_sink("plot", "{width_px: 800, height_px: 600}");
  auto reference = std::make_shared<Reference>();
  for (int i = 0; i < 100; ++i) {
    reference->trajectory.push_back({Time(from_seconds(0.1 * i)), Pose::planar(-5 + 0.1 * i, 0, 0), true});
  }
  sink->start({out_.path(), nullptr, reference});
  FakeSnapshot snapshot;
  drive(*sink, snapshot, false);
  sink->finish(&snapshot, {});
  const cv::Mat image = picture();
  bool red = false;
  for (int y = kMiddleY - 4; y <= kMiddleY + 4; ++y) {
    const auto& p = image.at<cv::Vec3b>(y, kMiddleX);
    red = red || (p[2] > 180 && p[1] < 120 && p[0] < 120);
  }
  EXPECT_TRUE(red);
}

TEST_F(PlotSink, DrawsAReferenceOfAnotherFrameOnTheEstimate) {
  const auto sink = make_sink("plot", "{width_px: 800, height_px: 600, ellipses: false}");
  auto reference = std::make_shared<Reference>();
  for (int i = 0; i <= 40; ++i) {
    const double along = 0.5 * i;
    const Pose T = i <= 20 ? Pose::planar(along - 5, -5, 0) : Pose::planar(5, along - 15, 1.57);
    reference->trajectory.push_back({Time(from_seconds(0.1 * i)), Pose::planar(500, 200, 0.5) * T, true});
  }
  sink->start({out_.path(), nullptr, reference});
  FakeSnapshot snapshot;
  drive(*sink, snapshot, false);
  sink->finish(&snapshot, {});
  // Drawn where it is, 500 m away, the estimate would be a dot: the corner of the square would not be in the picture's
  // lower right.
  EXPECT_GT(marked(picture(), cv::Rect(500, 400, 130, 165)), 100);
}

TEST_F(PlotSink, DrawsAGeodeticFixWhereTheDatumPlacesIt) {
  for (const bool is_known : {false, true}) {
    const auto sink = make_sink("plot", "{width_px: 800, height_px: 600, ellipses: false, window_m: [-1, -1, 1, 1]}");
    sink->start({out_.path(), nullptr, nullptr});
    FakeSnapshot snapshot;
    if (is_known) snapshot.datum_ = Datum{49.0, 8.0, 0.0};
    auto fix = std::make_shared<GnssFix>();
    fix->latitude_deg = 49.0;
    fix->longitude_deg = 8.0;
    snapshot.measurement_.payload = fix;
    sink->write(snapshot.at(0.0, Pose::planar(50, 50, 0)));
    sink->finish(&snapshot, {});
    EXPECT_EQ(marked(picture(), cv::Rect(kMiddleX - 4, kMiddleY - 4, 8, 8)) > 0, is_known);
  }
}

/// A survey of one thing, far from where the robot drives.
std::shared_ptr<Reference> thing_at(double east, double north) {
  auto reference = std::make_shared<Reference>();
  reference->landmarks.push_back({"thing", {east, north}, 0.5});
  return reference;
}

TEST_F(PlotSink, ShowsTheWindowAskedForInItsMiddle) {
  const cv::Rect around(kMiddleX - 8, kMiddleY - 8, 16, 16);
  for (const bool inside : {false, true}) {
    const auto sink = make_sink("plot", "{width_px: 800, height_px: 600, window_m: [90, 40, 110, 60]}");
    sink->start({out_.path(), nullptr, thing_at(inside ? 100.0 : 109.0, 50.0)});
    FakeSnapshot snapshot;
    drive(*sink, snapshot, false);
    sink->finish(&snapshot, {});
    EXPECT_EQ(marked(picture(), around) > 0, inside);
  }
}

TEST_F(PlotSink, InUtmTheGridTurnsAgainstNorth) {
  // 3° east of the zone's central meridian, at 49° north, the grid's north is 3° · sin 49° = 2.26° east of true north:
  // what lies 1000 m true north of the origin is 39.5 m west of it in the grid, and 999 m north.
  for (const bool utm : {false, true}) {
    const auto sink = make_sink("plot", std::string("{width_px: 800, height_px: 600, window_m: [-49.5, 988.8, -29.5, "
                                                    "1008.8]") +
                                            (utm ? ", utm_origin_deg: [49, 11.999] }" : " }"));
    sink->start({out_.path(), nullptr, thing_at(0.0, 1000.0)});
    FakeSnapshot snapshot;
    drive(*sink, snapshot, false);
    sink->finish(&snapshot, {});
    // Wider labels move the map's middle to the right.
    const int middle = utm ? kMiddleX + 8 : kMiddleX;
    EXPECT_EQ(marked(picture(), cv::Rect(middle - 16, kMiddleY - 16, 32, 32)) > 0, utm);
  }
}

TEST_F(PlotSink, LeavesTheEllipsesOutIfAsked) {
  std::vector<int> counts;
  for (const char* ellipses : {"true", "false"}) {
    const auto sink =
        make_sink("plot", std::string("{width_px: 800, height_px: 600, sigma: 9, ellipses: ") + ellipses + "}");
    sink->start({out_.path(), nullptr, nullptr});
    FakeSnapshot snapshot;
    drive(*sink, snapshot, false);
    sink->finish(&snapshot, {});
    counts.push_back(marked(picture(), cv::Rect(40, 40, 590, 500)));
  }
  EXPECT_GT(counts[0], counts[1] + 500);
}

TEST_F(PlotSink, ColoursCellsInWhichParticlesDisagreeIfAsked) {
  for (const bool asked : {false, true}) {
    const auto sink = make_sink("plot", std::string("{width_px: 800, height_px: 600, ellipses: false, disagreement: ") +
                                            (asked ? "true}" : "false}"));
    sink->start({out_.path(), nullptr, nullptr});
    FakeSnapshot snapshot;
    snapshot.maps_ = {{"hall", {}}};
    snapshot.maps_[0].grid = GridView{Pose::planar(-10, -10, 0.0), 10.0, 2, 2, {0, 100, 0, 100}};
    snapshot.maps_[0].mixture = GridView{Pose::planar(-10, -10, 0.0), 10.0, 2, 2, {0, 100, 0, 60}};
    sink->write(snapshot.at(0, Pose()));
    sink->finish(&snapshot, {});
    const cv::Mat image = picture();
    int orange = 0;  // in the map's area: the legend has a sample of it
    for (int y = 36; y < 571; ++y) {
      for (int x = 39; x < 635; ++x) orange += image.at<cv::Vec3b>(y, x) == cv::Vec3b(34, 88, 226) ? 1 : 0;
    }
    // A quarter of the square of 20 m.
    EXPECT_EQ(orange > 10000, asked) << orange;
  }
}

TEST_F(PlotSink, DrawsAMapBesideAReferenceInAbsoluteCoordinates) {
  const auto sink = make_sink("plot", "{width_px: 800, height_px: 600}");
  auto reference = std::make_shared<Reference>();
  for (int k = 0; k < 3; ++k)
    reference->trajectory.push_back({Time{from_seconds(k)}, Pose::planar(458000.0 + k, 5428000.0, 0.0), false});
  sink->start({out_.path(), nullptr, reference});
  FakeSnapshot snapshot;
  snapshot.maps_ = {{"hall", {}}};
  snapshot.maps_[0].grid = GridView{Pose::planar(-1, -1, 0.0), 0.05, 40, 2, std::vector<std::uint8_t>(80, 100)};
  sink->write(snapshot.at(0, Pose()));
  sink->finish(&snapshot, {});
  EXPECT_EQ(picture().cols, 800);
}

TEST_F(PlotSink, SaysNoDataWithoutASnapshot) {
  const auto sink = make_sink("plot", "{width_px: 800, height_px: 600}");
  sink->start({out_.path(), nullptr, nullptr});
  sink->finish(nullptr, {});
  const cv::Mat image = picture();
  ASSERT_EQ(image.size(), cv::Size(800, 600));
  EXPECT_GT(marked(image, cv::Rect(kMiddleX - 60, kMiddleY - 25, 120, 50)), 200) << "the words";
  EXPECT_EQ(marked(image, cv::Rect(650, 36, 140, 500)), 0) << "a legend of nothing";
}

TEST_F(PlotSink, SurvivesAFilterThatNeverStarted) {
  const auto sink = make_sink("plot", "{width_px: 800, height_px: 600}");
  sink->start({out_.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  snapshot.started_ = false;
  snapshot.at(1.0, Pose());
  sink->write(snapshot);
  sink->finish(&snapshot, {});
  EXPECT_GT(marked(picture(), cv::Rect(kMiddleX - 60, kMiddleY - 25, 120, 50)), 200);
}

TEST_F(PlotSink, SurvivesNumbersThatAreNotFinite) {
  const auto sink = make_sink("plot", "{width_px: 800, height_px: 600}");
  sink->start({out_.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  drive(*sink, snapshot);
  snapshot.maps_[0].landmarks.push_back(snapshot.maps_[0].landmarks[0]);
  snapshot.maps_[0].landmarks[1].P.setConstant(std::numeric_limits<double>::quiet_NaN());
  snapshot.maps_[0].landmarks[1].p_map.setConstant(std::numeric_limits<double>::infinity());
  sink->finish(&snapshot, {});
  EXPECT_EQ(picture().size(), cv::Size(800, 600));
}

TEST_F(PlotSink, GivesTheSameBytesForTheSameRun) {
  std::string first;
  for (int i = 0; i < 2; ++i) {
    const auto sink = make_sink("plot", "{width_px: 800, height_px: 600}");
    sink->start({out_.path(), nullptr, nullptr});
    FakeSnapshot snapshot;
    drive(*sink, snapshot);
    sink->finish(&snapshot, {});
    const std::string bytes = out_.read("map.png");
    ASSERT_FALSE(bytes.empty());
    if (i == 0) first = bytes;
    EXPECT_TRUE(bytes == first);
  }
}

TEST_F(PlotSink, RefusesWhatItCannotDraw) {
  EXPECT_THROW(make_sink("plot", "{width_px: 10}"), ConfigError);
  EXPECT_THROW(make_sink("plot", "{sigma: 0}"), ConfigError);
  EXPECT_THROW(make_sink("plot", "{landmark_labels: some}"), ConfigError);
  EXPECT_THROW(make_sink("plot", "{file: map.jpg}"), ConfigError);
  EXPECT_THROW(make_sink("plot", "{window_m: [0, 0, 10]}"), ConfigError);
  EXPECT_THROW(make_sink("plot", "{window_m: [10, 0, 0, 10]}"), ConfigError);
  EXPECT_THROW(make_sink("plot", "{utm_origin_deg: [89, 8]}"), ConfigError);
}

}  // namespace
}  // namespace waymark
