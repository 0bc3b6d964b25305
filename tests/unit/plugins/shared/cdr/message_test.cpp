// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/cdr/message.hpp"

#include <gmock/gmock.h>

#include <bit>

#include "unit/plugins/shared/cdr/all_messages.hpp"

namespace waymark::ros_test {
namespace {

using ros::Bytes;
using ros::Unusable;

std::vector<std::uint8_t> bytes(std::initializer_list<int> values) {
  std::vector<std::uint8_t> out;
  out.reserve(values.size());
  for (const int value : values) out.push_back(static_cast<std::uint8_t>(value));
  return out;
}

TEST(Cdr, NumbersAreAlignedBehindTheEncapsulation) {
  ros::geometry_msgs::PoseStamped pose;
  pose.header = {{5, 6}, "map"};
  pose.pose.position.x = 1.0;
  const auto written = ros::to_cdr(pose);
  // Encapsulation, seconds, nanoseconds, length with the zero, text; the next multiple of 8 is 16.
  const auto expected = bytes({0, 1, 0, 0, 5, 0, 0,    0,   6, 0, 0, 0, 4, 0, 0, 0, 'm', 'a', 'p', 0,  //
                               0, 0, 0, 0, 0, 0, 0xf0, 0x3f});
  ASSERT_EQ(written.size(), 4U + 16 + 7 * 8);
  EXPECT_TRUE(std::equal(expected.begin(), expected.begin() + 20, written.begin()));
  EXPECT_TRUE(std::equal(expected.begin() + 20, expected.end(), written.begin() + 20));
}

TEST(Cdr, PaddingFollowsAText) {
  ros::std_msgs::Header header{{1, 2}, "ab"};
  ros::geometry_msgs::TwistStamped twist{header, {}};
  const auto written = ros::to_cdr(twist);
  EXPECT_EQ(written.size(), 4U + 16 + 6 * 8);  // 15 bytes of header and one of padding
  EXPECT_EQ(ros::from_cdr<ros::geometry_msgs::TwistStamped>(written), twist);
}

TEST(Cdr, EveryMessageReadsBackAsItWasWritten) {
  for_each_message([]<class M>(const M& message) {
    EXPECT_EQ(ros::from_cdr<M>(ros::to_cdr(message)), message) << M::kType;
    EXPECT_EQ(ros::from_cdr<M>(ros::to_cdr(M())), M()) << M::kType;
  });
}

TEST(Cdr, AMessageThatEndsEarlyIsUnusable) {
  for_each_message([]<class M>(const M& message) {
    const auto whole = ros::to_cdr(message);
    for (std::size_t size = 0; size < whole.size(); ++size)
      EXPECT_THROW(ros::from_cdr<M>(Bytes(whole).first(size)), Unusable) << M::kType << " of " << size << " bytes";
  });
}

TEST(Cdr, PaddingToFourBytesMayFollowAndNothingElse) {
  auto whole = ros::to_cdr(ros::std_msgs::Header{{1, 2}, "abc"});
  whole.resize(whole.size() + 3);
  EXPECT_NO_THROW(ros::from_cdr<ros::std_msgs::Header>(whole));
  whole.resize(whole.size() + 1);
  EXPECT_THROW(ros::from_cdr<ros::std_msgs::Header>(whole), Unusable);
}

TEST(Cdr, BigEndianIsRead) {
  const auto message = bytes({0, 0, 0, 0, 0, 0, 0, 5, 0, 0, 0, 6, 0, 0, 0, 4, 'm', 'a', 'p', 0,  //
                              0, 0, 0, 3,                                                        // width
                              0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 3, 1,   2,   0xff});
  // As of OccupancyGridUpdate: x, y, width, height, data.
  const auto update = ros::from_cdr<ros::map_msgs::OccupancyGridUpdate>(message);
  EXPECT_EQ(update.header, (ros::std_msgs::Header{{5, 6}, "map"}));
  EXPECT_EQ(update.x, 3);
  EXPECT_EQ(update.y, 2);
  EXPECT_THAT(update.data, testing::ElementsAre(1, 2, -1));
}

TEST(Cdr, BigEndianListsOfNumbersAreRead) {
  auto message = bytes({0, 0, 0, 0, 0, 0, 0, 5, 0, 0, 0, 6, 0, 0, 0, 1, 0, 0, 0, 0});
  for (int i = 0; i < 7; ++i) message.insert(message.end(), {0x3f, 0x80, 0, 0});
  message.insert(message.end(), {0, 0, 0, 2, 0x3f, 0x80, 0, 0, 0x40, 0, 0, 0, 0, 0, 0, 0});
  const auto scan = ros::from_cdr<ros::sensor_msgs::LaserScan>(message);
  EXPECT_EQ(scan.angle_min, 1.0f);
  EXPECT_THAT(scan.ranges, testing::ElementsAre(1.0f, 2.0f));
}

TEST(Cdr, OtherEncapsulationsAreRefused) {
  auto message = ros::to_cdr(ros::std_msgs::Header{{1, 2}, "abc"});
  for (const int kind : {2, 3, 6, 7, 8, 9, 10, 255}) {
    message[1] = static_cast<std::uint8_t>(kind);
    EXPECT_THROW(ros::from_cdr<ros::std_msgs::Header>(message), Unusable) << kind;
  }
}

TEST(Cdr, ACountThatTheBytesCannotHoldIsRefusedBeforeMemoryIsTaken) {
  ros::nav_msgs::Path path;
  path.poses.resize(2);
  auto message = ros::to_cdr(path);
  const std::size_t count_at = 4 + 16;  // behind a header with an empty frame: 8 + 4 + 1, aligned
  ASSERT_EQ(message[count_at], 2);
  for (const std::uint8_t count : {3, 250}) {
    message[count_at] = count;
    message[count_at + 3] = count == 250 ? 0xff : 0;
    EXPECT_THROW(ros::from_cdr<ros::nav_msgs::Path>(message), Unusable);
  }
}

TEST(Cdr, NotANumberKeepsItsBits) {
  ros::geometry_msgs::Vector3 v;
  v.x = std::bit_cast<double>(0x7ff4'0000'dead'beefULL);
  const auto again = ros::from_cdr<ros::geometry_msgs::Vector3>(ros::to_cdr(v));
  EXPECT_EQ(std::bit_cast<std::uint64_t>(again.x), 0x7ff4'0000'dead'beefULL);
}

TEST(Ros1, HasNoPaddingAndANumberInTheHeader) {
  const auto message = bytes({7, 0, 0, 0, 5, 0, 0, 0, 6, 0, 0, 0, 3, 0, 0, 0, 'm', 'a', 'p',  //
                              1, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1,   0,   0,   0, 0x64});
  const auto update = ros::from_ros1<ros::map_msgs::OccupancyGridUpdate>(message);
  EXPECT_EQ(update.header, (ros::std_msgs::Header{{5, 6}, "map"}));
  EXPECT_EQ(update.y, 2);
  EXPECT_THAT(update.data, testing::ElementsAre(100));
}

}  // namespace
}  // namespace waymark::ros_test
