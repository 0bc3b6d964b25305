// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/dds/names.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "plugins/shared/dds/domain.hpp"
#include "waymark/base/error.hpp"

namespace waymark::dds {
namespace {

TEST(DdsNames, TopicsAndTypesHaveTheNamesThatRos2GivesThem) {
  EXPECT_EQ(topic_name("/imu/data"), "rt/imu/data");
  EXPECT_EQ(topic_name("imu"), "rt/imu");
  EXPECT_EQ(type_name("sensor_msgs/msg/Imu"), "sensor_msgs::msg::dds_::Imu_");
  EXPECT_EQ(type_name("sensor_msgs/Imu"), "sensor_msgs::msg::dds_::Imu_");
  EXPECT_EQ(ros_type("sensor_msgs::msg::dds_::Imu_"), "sensor_msgs/msg/Imu");
  EXPECT_EQ(ros_type("of_nobody"), "of_nobody");
}

TEST(DdsNames, WhatIsNoNameIsRefused) {
  for (const char* topic : {"", "/", "/a//b", "/a/", "a b", "/1a", "/ä"})
    EXPECT_THROW(topic_name(topic), std::invalid_argument) << topic;
  for (const char* type : {"", "Imu", "a/b/c/d", "sensor_msgs/srv/Imu", "sensor_msgs/msg/", "a::b"})
    EXPECT_THROW(type_name(type), std::invalid_argument) << type;
}

TEST(DdsDomain, IsThatOfTheYamlElseThatOfTheEnvironment) {
  ::setenv("ROS_DOMAIN_ID", "17", 1);
  EXPECT_EQ(read_domain_settings(Config::parse("{}")).id, 17U);
  EXPECT_EQ(read_domain_settings(Config::parse("{ domain: 3 }")).id, 3U);
  ::setenv("ROS_DOMAIN_ID", "many", 1);
  EXPECT_THROW(read_domain_settings(Config::parse("{}")), ConfigError);
  ::unsetenv("ROS_DOMAIN_ID");
  EXPECT_EQ(read_domain_settings(Config::parse("{}")).id, 0U);
}

TEST(DdsDomain, StaysOnThisMachineUnlessTheYamlNamesAnInterface) {
  const auto xml = [](const char* yaml) { return domain_configuration(read_domain_settings(Config::parse(yaml))); };
  EXPECT_NE(xml("{}").find("name=\"lo\""), std::string::npos);
  EXPECT_NE(xml("{ interface: eth0 }").find("name=\"eth0\""), std::string::npos);
  EXPECT_EQ(xml("{ interface: eth0 }").find("127.0.0.1"), std::string::npos);
  EXPECT_THROW(xml("{ interface: '\"/><x y=\"' }"), ConfigError);
}

}  // namespace
}  // namespace waymark::dds
