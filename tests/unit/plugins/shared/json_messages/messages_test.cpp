// SPDX-License-Identifier: Apache-2.0
// Payloads become messages and messages payloads, to the bit; the page of messages lists them.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include "plugins/shared/json_messages/base64.hpp"
#include "plugins/shared/json_messages/payload_text.hpp"
#include "tests/unit/plugins/shared/json_messages/examples.hpp"
#include "waymark/interface/payload_description.hpp"

namespace waymark::json_messages {
namespace {

using ::testing::ElementsAre;

constexpr Time kStamp{Duration(1'700'000'000'250'000'001)};

template <class P>
P read(const std::string& fields) {
  const Message message = parse_message(R"({"sensor":"s",)" + fields + "}");
  return static_cast<const P&>(*read_payload(message, P::kType));
}
std::optional<Time> stamp_of(const std::string& stamp) {
  return parse_message(R"({"sensor":"s",)" + stamp + "}").stamp;
}

TEST(JsonMessages, EveryCorePayloadComesBackToTheBit) {
  for (const std::string_view type : core_payload_types()) {
    const auto payload = example_of(type);
    ASSERT_EQ(payload->problem(), "") << type;
    const std::string line = write_message("front", kStamp, *payload);
    const Message message = parse_message(line);
    EXPECT_EQ(message.sensor, "front");
    EXPECT_EQ(message.stamp, kStamp);
    EXPECT_EQ(write_message("front", kStamp, *read_payload(message, type)), line);
  }
}

TEST(JsonMessages, WhatIsNotKnownComesBackAsNotKnown) {
  GnssFix fix;
  fix.latitude_deg = 49.1;
  fix.longitude_deg = 8.3;
  const std::string line = write_message("gps", std::nullopt, fix);
  EXPECT_EQ(line, R"({"sensor":"gps","latitude_deg":49.1,"longitude_deg":8.3,"satellites":-1,"type":"unknown"})");
  const Message message = parse_message(line);
  EXPECT_FALSE(message.stamp.has_value());
  const auto back = read_payload(message, GnssFix::kType);
  EXPECT_EQ(write_message("gps", std::nullopt, *back), line);

  LaserScan scan;
  scan.step_rad = 0.1;
  scan.ranges_m = {1.5f, std::numeric_limits<float>::infinity(), 0.1f};
  const std::string beams = write_message("lidar", kStamp, scan);
  EXPECT_THAT(beams, testing::HasSubstr("[1.5,null,0.1]"));
  EXPECT_EQ(write_message("lidar", kStamp, *read_payload(parse_message(beams), LaserScan::kType)), beams);
}

TEST(JsonMessages, NullAndAbsentAreNotKnown) {
  const auto fix = read<GnssFix>(R"("east_m":1,"north_m":2,"up_m":null,"satellites":null,"hdop":null)");
  EXPECT_EQ(fix.p_map_antenna.head<2>(), Eigen::Vector2d(1.0, 2.0));
  EXPECT_TRUE(std::isnan(fix.p_map_antenna.z()) && std::isnan(fix.hdop) && std::isnan(fix.latitude_deg));
  EXPECT_EQ(fix.satellites, -1);
  const auto imu = read<ImuSample>(R"("w_x_radps":null,"w_y_radps":null,"w_z_radps":null,"f_x_mps2":0,"f_y_mps2":0,)"
                                   R"("f_z_mps2":9.81)");
  EXPECT_TRUE(imu.w_sensor.array().isNaN().all());
  EXPECT_EQ(imu.f_sensor.z(), 9.81);
  EXPECT_EQ(read<BodyTwist>(R"("v_x_mps":1,"v_y_mps":null,"w_z_radps":0)").v_y_mps, 0.0) << "the default";
}

TEST(JsonMessages, StampsLoseNoDigit) {
  EXPECT_EQ(stamp_of(R"("stamp":1700000000.250000001)"), kStamp);
  EXPECT_EQ(stamp_of(R"("stamp":1.700000000250000001e9)"), kStamp);
  EXPECT_EQ(stamp_of(R"("stamp":1700000000)"), Time(std::chrono::seconds(1'700'000'000)));
  EXPECT_EQ(stamp_of(R"("stamp":-1.5)"), Time(std::chrono::milliseconds(-1500)));
  EXPECT_EQ(stamp_of(R"("stamp_ns":1700000000250000001)"), kStamp);
  EXPECT_EQ(stamp_of(R"("stamp":null,"stamp_ns":null)"), std::nullopt);
}

TEST(JsonMessages, AQuaternionOfAFewDigitsIsMadeAUnit) {
  const auto imu =
      read<ImuSample>(R"("w_x_radps":0,"w_y_radps":0,"w_z_radps":0,"q_w":0.707,"q_x":0,"q_y":0,"q_z":0.707)");
  EXPECT_NEAR(imu.q_enu_sensor.norm(), 1.0, 1e-15);
  EXPECT_NEAR(imu.q_enu_sensor.w(), std::sqrt(0.5), 1e-12);
}

TEST(JsonMessages, KeysMayComeInAnyOrder) {
  const Message message = parse_message(R"( {"right_mps": 2, "stamp_ns": 5, "left_mps": 1e0, "sensor": "w\u00e4"} )");
  EXPECT_EQ(message.sensor, "wä");
  const auto wheels = read_payload(message, WheelSpeeds::kType);
  EXPECT_EQ(static_cast<const WheelSpeeds&>(*wheels).right_mps, 2.0);
}

TEST(Base64, FollowsTheVectorsOfRfc4648) {
  const auto bytes = [](std::string_view text) { return std::vector<std::uint8_t>(text.begin(), text.end()); };
  const std::vector<std::pair<std::string_view, std::string_view>> vectors{{"", ""},
                                                                           {"f", "Zg=="},
                                                                           {"fo", "Zm8="},
                                                                           {"foo", "Zm9v"},
                                                                           {"foob", "Zm9vYg=="},
                                                                           {"fooba", "Zm9vYmE="},
                                                                           {"foobar", "Zm9vYmFy"}};
  for (const auto& [plain, coded] : vectors) {
    EXPECT_EQ(to_base64(bytes(plain)), coded);
    EXPECT_EQ(from_base64(coded), bytes(plain));
  }
  EXPECT_EQ(from_base64("Zm8"), bytes("fo")) << "without padding";
  for (const std::string_view bad : {"Z", "Zg=", "Zm9v=", "Zm 9", "Zm9v\n", "====", "Zg==Zg=="})
    EXPECT_EQ(from_base64(bad), std::nullopt) << bad;
}

std::string section_of(std::string_view type, const std::vector<FieldDescription>& fields) {
  std::string text = "\n## " + std::string(short_type_name(type)) + "\n\n```json\n" +
                     write_message("name", kStamp, *example_of(type)) + "\n```\n\nRequired:";
  bool any = false;
  for (const FieldDescription& field : fields) {
    if (!field.info.required || field.name.find('.') != std::string::npos) continue;
    text += (any ? ", `" : " `") + field.name + "`";
    if (!field.info.unknown.empty()) {
      text += field.kind.starts_with("list") ? " (null in it: " + std::string(field.info.unknown) + ")"
                                             : std::string(" (null: not known)");
    }
    any = true;
  }
  return text + (any ? ".\n" : " nothing.\n");
}

std::string page() {
  std::string text =
      "# Messages in JSON\n\nOne line, one message, as the source [json](../plugins/sources/json/README.md) reads it. "
      "Generated from the fields that [payloads.hpp](../core/include/waymark/interface/payloads.hpp) registers; a test "
      "compares them, and reads every line of this page.\nUnits and meanings: [payloads.md](payloads.md). What is not "
      "required may be null or left out: it is not known, or has its default.\n";
  std::apply([&]<class... P>(const P&...) { ((text += section_of(P::kType, describe_fields<P>())), ...); },
             CorePayloads());
  return text;
}

TEST(JsonMessages, ThePageShowsAMessageOfEveryPayload) {
  std::ifstream file(WAYMARK_SOURCE_DIR "/docs/json.md");
  std::stringstream committed;
  committed << file.rdbuf();
  EXPECT_TRUE(committed.str() == page()) << "docs/json.md should be:\n" << page();
}

}  // namespace
}  // namespace waymark::json_messages
