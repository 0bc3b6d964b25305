// SPDX-License-Identifier: Apache-2.0
// Lines that are not messages: each is refused with a reason, however it is made.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <random>

#include "plugins/shared/json_messages/payload_text.hpp"
#include "tests/unit/plugins/shared/json_messages/examples.hpp"

namespace waymark::json_messages {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Le;
using ::testing::StartsWith;

/// Why the line is not a message of that payload; empty if it is one.
std::string reason(const std::string& line, std::string_view payload_type) {
  try {
    read_payload(parse_message(line), payload_type);
    return "";
  } catch (const BadMessage& bad) {
    return bad.what();
  }
}
template <class P>
std::string reason(const std::string& fields) {
  return reason(R"({"sensor":"s",)" + fields + "}", P::kType);
}

TEST(BadMessages, AreNamedByWhatIsWrong) {
  constexpr std::string_view kWheels = WheelSpeeds::kType;
  EXPECT_THAT(reason("", kWheels), StartsWith("no JSON at byte"));
  EXPECT_THAT(reason(R"({"sensor":"s","left_mps":1)", kWheels), StartsWith("no JSON at byte"));
  EXPECT_THAT(reason(R"({"sensor":"s"} {})", kWheels), StartsWith("no JSON at byte"));
  EXPECT_THAT(reason("NaN", kWheels), StartsWith("no JSON at byte"));
  EXPECT_EQ(reason("3", kWheels), "it is a single value; an object {\"sensor\": …} is expected");
  EXPECT_EQ(reason("[]", kWheels), "it is a list; an object {\"sensor\": …} is expected");
  EXPECT_EQ(reason("{}", kWheels), "it names no \"sensor\"");
  EXPECT_EQ(reason(R"({"sensor":3})", kWheels), "\"sensor\" is not text");
  EXPECT_EQ(reason<WheelSpeeds>(R"("left_mps":1)"), "right_mps is missing");
  EXPECT_EQ(reason<WheelSpeeds>(R"("left_mps":1,"right_mps":null)"), "right_mps is null");
  EXPECT_EQ(reason<WheelSpeeds>(R"("left_mps":1,"right_mps":"2")"), "right_mps is not a number");
  EXPECT_EQ(reason<WheelSpeeds>(R"("left_mps":1,"right_mps":[2])"), "right_mps is a list");
  EXPECT_EQ(reason<WheelSpeeds>(R"("left_mps":1,"left_mps":1,"right_mps":2)"), "\"left_mps\" comes twice");
  EXPECT_EQ(reason<WheelSpeeds>(R"("left_mps":1,"right_mps":2,"rigth_mps":2)"),
            "WheelSpeeds has no field \"rigth_mps\"; did you mean \"right_mps\"?; its fields: left_mps, right_mps");
  EXPECT_THAT(reason<WheelSpeeds>(R"("left_mps":1,"right_mps":1e999)"), StartsWith("no JSON at byte"));
  EXPECT_EQ(reason<WheelSpeeds>(R"("left_mps":{"a":1},"right_mps":1)"),
            "\"left_mps\" is an object; a number, a word or a list is expected");
  EXPECT_EQ(reason<GnssFix>(R"("east_m":1,"north_m":2,"satellites":2.5)"), "satellites is not an integer");
  EXPECT_EQ(reason<GnssFix>(R"("east_m":1,"north_m":2,"satellites":3000000000)"), "satellites is too large");
  EXPECT_EQ(reason<GnssFix>(R"("east_m":1,"north_m":2,"type":"rtk")"),
            "type is not one of: none, single, differential, rtk_float, rtk_fixed, unknown");
  EXPECT_EQ(reason<GnssFix>(R"("latitude_deg":91,"longitude_deg":2)"), "latitude_deg is beyond ±90");
  EXPECT_EQ(reason<GnssFix>(R"("hdop":1)"), "a fix has neither east and north nor latitude and longitude");
  EXPECT_EQ(reason<CompassHeading>(R"("heading_rad":1,"from_true_north":1)"),
            "from_true_north is neither true nor false");
  EXPECT_EQ(reason<LaserScan>(R"("start_rad":0,"step_rad":1,"ranges_m":3)"), "ranges_m is not a list");
  EXPECT_EQ(reason<LaserScan>(R"("start_rad":0,"step_rad":1,"ranges_m":[1e39])"),
            "ranges_m holds a number that is too large");
  EXPECT_EQ(reason<LaserScan>(R"("start_rad":0,"step_rad":1,"ranges_m":["1"])"),
            "an element of \"ranges_m\" is not a number");
  EXPECT_EQ(reason<LaserScan>(R"("start_rad":0,"step_rad":1,"ranges_m":[[1,2,3]])"),
            "ranges_m is not a list of numbers");
  EXPECT_EQ(reason<PointCloud>(R"("points_m":[[1,2]])"), "a point has 2 numbers; x, y, z are expected");
  EXPECT_EQ(reason<PointCloud>(R"("points_m":[1,2,3])"), "points_m is not a list of points");
  EXPECT_EQ(reason<PointCloud>(R"("points_m":[[1,2,null]])"), "points_m holds null");
  EXPECT_EQ(reason<PointCloud>(R"("points_m":[[1,2,3],4])"), "\"points_m\" is a list of different things");
  EXPECT_EQ(reason<Image>(R"("encoding":"compressed","data":"?")"), "data is not base64");
  EXPECT_EQ(reason<LandmarkObservations>(R"("landmarks":[{"range_m":1}])"), "bearing_rad is missing");
  EXPECT_EQ(reason<LandmarkObservations>(R"("landmarks":[{"range_m":1,"bearing_rad":0,"x":1}])"),
            "an element has no field \"x\"; its fields: range_m, bearing_rad, radius_m, identity");
  EXPECT_EQ(reason<LandmarkObservations>(R"("landmarks":[1])"), "landmarks is not a list of objects");
  EXPECT_EQ(reason<ImuSample>(R"("w_x_radps":0,"w_y_radps":null,"w_z_radps":0)"),
            "a vector of an IMU is neither finite nor unknown");
  EXPECT_EQ(reason<ImuSample>(R"("w_x_radps":0,"w_y_radps":0,"w_z_radps":0,"q_w":2,"q_x":0,"q_y":0,"q_z":0)"),
            "q_w to q_z are not a unit quaternion: their norm is 2");
}

TEST(BadMessages, StampsAreNumbersThatFit) {
  const auto wheels = [](const std::string& stamp) {
    return reason<WheelSpeeds>(stamp + R"(,"left_mps":1,"right_mps":2)");
  };
  EXPECT_EQ(wheels(R"("stamp":"now")"), "stamp is not a number");
  EXPECT_EQ(wheels(R"("stamp_ns":1.5)"), "stamp_ns is not an integer");
  EXPECT_EQ(wheels(R"("stamp_ns":9223372036854775808)"), "stamp_ns 9223372036854775808 is beyond int64 nanoseconds");
  EXPECT_EQ(wheels(R"("stamp":18446744073709551615)"), "stamp 18446744073709551615 is beyond int64 nanoseconds");
  EXPECT_THAT(wheels(R"("stamp":1e300)"), HasSubstr("lies more than 146 years from the epoch"));
  for (const char* beyond : {"4611686018427387904", "-4611686018427387904", "-9223372036854775808"}) {
    EXPECT_EQ(wheels(std::string(R"("stamp_ns":)") + beyond),
              std::string("stamp_ns ") + beyond + " lies more than 146 years from the epoch");
  }
  EXPECT_EQ(wheels(R"("stamp":1,"stamp_ns":1)"), "it has two stamps");
  EXPECT_EQ(wheels(R"("stamp":[1])"), "it is nested too deep");
}

TEST(BadMessages, AreRefusedHoweverDeepTheyAreNested) {
  const std::string deep(1'000'000, '[');
  EXPECT_EQ(reason<LaserScan>(R"("ranges_m":)" + deep), "it is nested too deep");
  std::string objects;
  for (int i = 0; i < 100'000; ++i) objects += R"({"a":)";
  EXPECT_THAT(reason(objects, LaserScan::kType), HasSubstr("is an object"));
  EXPECT_EQ(reason<LandmarkObservations>(R"("landmarks":[{"range_m":[1]}])"), "it is nested too deep");
}

TEST(BadMessages, ManyKeysAreRefused) {
  std::string keys = R"("left_mps":1)";
  for (int i = 0; i < 100'000; ++i) keys += fmt::format(R"(,"k{}":1)", i);
  EXPECT_EQ(reason<WheelSpeeds>(keys), "an object has more than 64 keys");
}

TEST(BadMessages, TheReasonIsShortAndPrintable) {
  const std::string rubbish(100'000, '\x07');
  const std::vector<std::string> lines{rubbish,
                                       "{\"" + std::string(100'000, 'k') + "\":1}",
                                       R"({"sensor":"s",")" + std::string(90'000, 'k') + "\":1}",
                                       "{\"sensor\":\"" + std::string(1000, '\xff'),
                                       std::string("{\"sensor\":\"\xc3\xa4\",\"\xc3\xa4\":1}"),
                                       R"({"sensor":"s","\u0007\u001b[31m":1})"};
  for (const std::string& line : lines) {
    const std::string text = reason(line, WheelSpeeds::kType);
    EXPECT_THAT(text.size(), AllOf(testing::Gt(0U), Le(300U)));
    EXPECT_TRUE(std::ranges::all_of(text, [](char c) {
      return c == '\xe2' || c == '\x80' || c == '\xa6' || (c >= ' ' && c <= '~');
    })) << text;
  }
}

/// Cut, changed, and pieced together of two: nothing but a message or a BadMessage comes out.
TEST(BadMessages, DamagedLinesAreMessagesOrRefused) {
  std::mt19937 random(7);
  const auto below = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random); };
  const auto types = core_payload_types();
  constexpr std::string_view kSigns = "{}[]\",:0123456789.eE+-ntf \\u\xff\xc3\x00\x1f";
  std::size_t refused = 0;
  constexpr int kRounds = 20'000;
  for (int round = 0; round < kRounds; ++round) {
    const std::string_view type = types[below(types.size())];
    std::string line = write_message("s", Time(Duration(5)), *example_of(type));
    switch (below(4)) {
      case 0:
        line.resize(below(line.size()));
        break;
      case 1: {
        const std::string other = write_message("s", std::nullopt, *example_of(types[below(types.size())]));
        line = line.substr(0, below(line.size())) + other.substr(below(other.size()));
        break;
      }
      case 2:
        for (std::size_t i = below(8) + 1; i > 0; --i) line[below(line.size())] = kSigns[below(kSigns.size())];
        break;
      default:
        line.clear();
        for (std::size_t i = below(200); i > 0; --i) line += static_cast<char>(below(256));
    }
    if (!reason(line, type).empty()) ++refused;
  }
  EXPECT_GT(refused, kRounds / 2);
}

}  // namespace
}  // namespace waymark::json_messages
