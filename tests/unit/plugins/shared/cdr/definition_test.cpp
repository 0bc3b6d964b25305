// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/cdr/definition.hpp"

#include <gmock/gmock.h>

#include "plugins/shared/cdr/definition_text.hpp"
#include "unit/plugins/shared/cdr/all_messages.hpp"

namespace waymark::ros_test {
namespace {

using ros::Definition;
using ros::Unusable;
using testing::ElementsAre;

TEST(DefinitionText, ListsNestedTypesOnceBehindLinesOf80) {
  const std::string text = ros::definition_text<ros::geometry_msgs::PoseStamped>();
  const std::string line(80, '=');
  EXPECT_EQ(text,
            "std_msgs/Header header\ngeometry_msgs/Pose pose\n" + line +
                "\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n" + line +
                "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n" + line +
                "\nMSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n" +
                line + "\nMSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n" + line +
                "\nMSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n");
}

TEST(Definition, ReadsWhatTheStructsWrite) {
  for_each_message([]<class M>(const M& message) {
    const Definition definition(M::kType, ros::definition_text<M>());
    const auto numbers = definition.numbers(ros::to_cdr(message));
    EXPECT_EQ(numbers.size(), definition.number_paths().size()) << M::kType;
  });
}

TEST(Definition, GivesTheNumbersUnderTheirPaths) {
  ros::geometry_msgs::PoseWithCovarianceStamped message;
  Filler().fill(message);
  const Definition definition(message.kType, ros::definition_text<ros::geometry_msgs::PoseWithCovarianceStamped>());
  const auto numbers = definition.numbers(ros::to_cdr(message));
  const auto at = [&](std::string_view path) {
    const auto found = std::ranges::find(definition.number_paths(), path);
    return numbers.at(static_cast<std::size_t>(found - definition.number_paths().begin()));
  };
  EXPECT_EQ(at("header.stamp.sec"), message.header.stamp.sec);
  EXPECT_EQ(at("pose.pose.orientation.w"), message.pose.pose.orientation.w);
  EXPECT_EQ(at("pose.covariance[35]"), message.pose.covariance[35]);
}

TEST(Definition, NumbersBehindListsOfAnyLengthAreFound) {
  const Definition definition("a/msg/A",
                              "uint8[] raw\nB[] list\nfloat32 value 1.5\nuint16[2] two\nuint8 NAME=3 # a constant\n"
                              "string<=5 text\nint64 last # comment\n"
                              "===\nMSG: a/B\nstring name\nfloat64[3] v\n");
  EXPECT_THAT(definition.number_paths(), ElementsAre("value", "two[0]", "two[1]", "last"));
  ros::WireWriter out;
  out.count(3);
  for (const std::uint8_t byte : {1, 2, 3}) out.value(byte);
  out.count(1);
  out.text("name");
  for (const double v : {1.0, 2.0, 3.0}) out.value(v);
  out.value(2.5f);
  out.value(std::uint16_t{7});
  out.value(std::uint16_t{8});
  out.text("t");
  out.value(std::int64_t{-9});
  EXPECT_THAT(definition.numbers(out.bytes()), ElementsAre(2.5, 7.0, 8.0, -9.0));
}

TEST(Definition, LayoutsAreEqualIfTheBytesAre) {
  const auto layout = [](std::string_view text) { return Definition("a/msg/A", text).layout(); };
  EXPECT_EQ(layout("uint8 a\nfloat64 b\n"), layout("# other names\nbyte level\n\nfloat64 x 3.0\nint8 C=1\n"));
  EXPECT_NE(layout("uint8 a\nfloat64 b\n"), layout("float64 b\nuint8 a\n"));
  EXPECT_NE(layout("float64[3] a\n"), layout("float64[] a\n"));
  EXPECT_EQ(layout("Header header\n===\nMSG: std_msgs/Header\nstring a\n"),
            layout("std_msgs/msg/Header header\n===\nMSG: std_msgs/Header\nstring a\n"));
}

TEST(Definition, RefusesWhatItCannotUnfold) {
  EXPECT_THROW(Definition("a/msg/A", "B b\n"), Unusable);
  EXPECT_THROW(Definition("a/msg/A", "A again\n"), Unusable);
  EXPECT_THROW(Definition("a/msg/A", "float64[0] a\n"), Unusable);
  EXPECT_THROW(Definition("a/msg/A", "float64[-1] a\n"), Unusable);
  EXPECT_THROW(Definition("a/msg/A", "nonsense\n"), Unusable);
  EXPECT_THROW(Definition("a/msg/A", "===\nfloat64 a\n"), Unusable);
  std::string bomb = "B1[10] a\n";
  for (int i = 1; i < 30; ++i) {
    bomb +=
        "===\nMSG: a/B" + std::to_string(i) + "\nB" + std::to_string(i + 1) + " a\nB" + std::to_string(i + 1) + " b\n";
  }
  EXPECT_THROW(Definition("a/msg/A", bomb + "===\nMSG: a/B30\nfloat64 a\n"), Unusable);
  // Every path of a number repeats the names above it: long ones would take gigabytes.
  EXPECT_NO_THROW(Definition("a/msg/A", "float64 " + std::string(255, 'n') + "\n"));
  EXPECT_THROW(Definition("a/msg/A", "float64 " + std::string(256, 'n') + "\n"), Unusable);
}

TEST(Definition, AnEmptyMessageTakesOneByte) {
  const Definition definition("std_msgs/msg/Empty", "");
  ros::WireWriter out;
  out.value(std::uint8_t{0});
  EXPECT_EQ(definition.numbers(out.bytes()).size(), 1U);
}

}  // namespace
}  // namespace waymark::ros_test
