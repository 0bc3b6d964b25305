// SPDX-License-Identifier: Apache-2.0
// What the sink json_poses writes.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <numbers>

#include "plugins/shared/json_messages/payload_text.hpp"
#include "unit/plugins/sinks/fake_snapshot.hpp"

namespace waymark {
namespace {

using nlohmann::json;
using test::FakeSnapshot;
using test::make_sink;
using test::TemporaryFolder;
using ::testing::HasSubstr;
using ::testing::SizeIs;

TEST(JsonPoses, WritesPoseVelocityCovarianceAndHealth) {
  const TemporaryFolder out;
  const auto sink = make_sink("json_poses", "{ to: file }");
  sink->start({out.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  snapshot.at(0.5, Pose::planar(1.0, -2.0, std::numbers::pi / 2)).pose_variance(0.25, 0.5, 0.01);
  snapshot.belief_.stamp = Time(Duration(1'700'000'000'250'000'001));
  snapshot.belief_.mean.v_base = {3.0, 0.0, 0.0};
  snapshot.belief_.mean.w_base = {0.0, 0.0, -0.5};
  snapshot.health_.state = Health::State::degraded;
  snapshot.health_.reason = "gps \"x\" is silent";
  sink->write(snapshot);
  sink->finish(&snapshot, {});
  const auto lines = out.lines("poses.jsonl");
  ASSERT_THAT(lines, SizeIs(1));
  const json line = json::parse(lines[0]);
  EXPECT_EQ(line.at("type"), "pose");
  EXPECT_EQ(line.at("stamp_ns"), 1'700'000'000'250'000'001);
  EXPECT_EQ(line.at("x_m"), 1.0);
  EXPECT_EQ(line.at("y_m"), -2.0);
  EXPECT_NEAR(line.at("yaw_rad").get<double>(), std::numbers::pi / 2, 1e-12);
  EXPECT_NEAR(line.at("q_w").get<double>(), std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(line.at("q_z").get<double>(), std::sqrt(0.5), 1e-12);
  EXPECT_EQ(line.at("v_x_mps"), 3.0);
  EXPECT_EQ(line.at("w_z_radps"), -0.5);
  const auto P = line.at("covariance").get<std::vector<double>>();
  ASSERT_THAT(P, SizeIs(36));
  EXPECT_EQ(P[0], 0.25);
  EXPECT_EQ(P[7], 0.5);
  EXPECT_EQ(P[35], 0.01);
  EXPECT_EQ(P[14], 0.0) << "planar";
  EXPECT_EQ(line.at("health"), "degraded");
  EXPECT_EQ(line.at("reason"), "gps \"x\" is silent");
}

TEST(JsonPoses, WritesOnlyWhatTheFilterTook) {
  const TemporaryFolder out;
  const auto sink = make_sink("json_poses", "{ to: file, file: p.jsonl }");
  sink->start({out.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  snapshot.started_ = false;
  sink->write(snapshot);
  snapshot.started_ = true;
  for (const Fate fate : {Fate::fused, Fate::late, Fate::unusable, Fate::mapped}) {
    snapshot.fate_ = fate;
    sink->write(snapshot);
  }
  sink->front(snapshot.belief_);
  sink->finish(&snapshot, {});
  EXPECT_THAT(out.lines("p.jsonl"), SizeIs(2));
}

TEST(JsonPoses, AtTheFrontsRateOnlyTheFrontIsWritten) {
  const TemporaryFolder out;
  const auto sink = make_sink("json_poses", "{ to: file, when: front }");
  sink->start({out.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  sink->front(snapshot.belief_);  // the filter has not started
  sink->write(snapshot.at(1.0, Pose::planar(1.0, 0.0, 0.0)));
  snapshot.at(1.02, Pose::planar(1.1, 0.0, 0.0));
  sink->front(snapshot.belief_);
  sink->finish(&snapshot, {});
  const auto lines = out.lines("poses.jsonl");
  ASSERT_THAT(lines, SizeIs(1));
  EXPECT_EQ(json::parse(lines[0]).at("x_m"), 1.1);
}

TEST(JsonPoses, UnknownNumbersAreNull) {
  const TemporaryFolder out;
  const auto sink = make_sink("json_poses", "{ to: file }");
  sink->start({out.path(), nullptr, nullptr});
  FakeSnapshot snapshot;
  snapshot.belief_.mean.v_base.x() = std::numeric_limits<double>::quiet_NaN();
  snapshot.pose_variance(std::numeric_limits<double>::infinity(), 0.0, 0.0);
  sink->write(snapshot);
  sink->finish(&snapshot, {});
  const json line = json::parse(out.lines("poses.jsonl").at(0));
  EXPECT_TRUE(line.at("v_x_mps").is_null());
  EXPECT_TRUE(line.at("covariance").at(0).is_null());
}

TEST(JsonPoses, MessagesOfAPayloadAreReadBackByTheSource) {
  FakeSnapshot snapshot;
  snapshot.at(2.0, Pose::planar(3.0, 4.0, 0.5)).pose_variance(0.25, 0.75, 0.01);
  snapshot.belief_.mean.v_base = {1.5, 0.25, 0.0};
  snapshot.belief_.mean.w_base.z() = 0.125;
  const auto line_of = [&](const std::string& payload) {
    const TemporaryFolder out;
    const auto sink = make_sink("json_poses", "{ to: file, sensor: other_robot, payload: " + payload + " }");
    sink->start({out.path(), nullptr, nullptr});
    sink->write(snapshot);
    sink->finish(&snapshot, {});
    return json_messages::parse_message(out.lines("poses.jsonl").at(0));
  };
  const auto twist_message = line_of("BodyTwist");
  EXPECT_EQ(twist_message.sensor, "other_robot");
  EXPECT_EQ(twist_message.stamp, Time(std::chrono::seconds(2)));
  const auto twist = json_messages::read_payload(twist_message, BodyTwist::kType);
  EXPECT_EQ(static_cast<const BodyTwist&>(*twist).v_y_mps, 0.25);
  EXPECT_EQ(static_cast<const BodyTwist&>(*twist).w_z_radps, 0.125);
  const auto fix = json_messages::read_payload(line_of("GnssFix"), GnssFix::kType);
  EXPECT_EQ(static_cast<const GnssFix&>(*fix).p_map_antenna, Eigen::Vector3d(3.0, 4.0, 0.0));
  EXPECT_EQ(static_cast<const GnssFix&>(*fix).sigma_horizontal_m, std::sqrt(0.5));
}

TEST(JsonPoses, TheYamlIsChecked) {
  const auto error_of = [](const std::string& yaml) -> std::string {
    try {
      make_sink("json_poses", yaml);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(error_of("{ to: stdout }"), HasSubstr("file, udp, tcp, unix"));
  EXPECT_THAT(error_of("{ to: udp, port: 0 }"), HasSubstr("0 is not in [1, 65535]"));
  EXPECT_THAT(error_of("{ to: unix, path: /tmp/poses.sock }"), HasSubstr("path"));
  EXPECT_THAT(error_of("{ to: file, payload: GnssFix }"), HasSubstr("sensor"));
}

}  // namespace
}  // namespace waymark
