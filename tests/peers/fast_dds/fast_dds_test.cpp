// SPDX-License-Identifier: Apache-2.0
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <gmock/gmock.h>

#include <chrono>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <memory>
#include <string>
#include <vector>

#include "dds_domain.hpp"
#include "live_source.hpp"
#include "plugins/shared/cdr/message.hpp"
#include "plugins/shared/dds/names.hpp"
#include "plugins/shared/dds/reader.hpp"
#include "plugins/shared/dds/writer.hpp"
#include "rosPubSubTypes.h"
#include "unit/plugins/shared/cdr/all_messages.hpp"

namespace waymark {
namespace {

namespace fast = eprosima::fastdds::dds;
using test::eventually;

constexpr dds::Quality kReliable{};
constexpr dds::Quality kLatched{.reliable = true, .latched = true, .depth = 1};
constexpr std::chrono::seconds kPatience{2};

/// A participant of Fast DDS on the loopback interface only, without shared memory.
class FastDds {
 public:
  FastDds() {
    fast::DomainParticipantQos qos = fast::PARTICIPANT_QOS_DEFAULT;
    auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    udp->interfaceWhiteList.emplace_back("127.0.0.1");
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports.push_back(udp);
    participant_ = fast::DomainParticipantFactory::get_instance()->create_participant(test::own_domain(), qos);
    publisher_ = participant_->create_publisher(fast::PUBLISHER_QOS_DEFAULT);
    subscriber_ = participant_->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT);
  }
  ~FastDds() {
    participant_->delete_contained_entities();
    fast::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }
  FastDds(const FastDds&) = delete;
  FastDds& operator=(const FastDds&) = delete;

  template <class Support>
  fast::Topic* topic(const std::string& name) {
    const fast::TypeSupport type(new Support);
    type.register_type(participant_);
    return participant_->create_topic(dds::topic_name(name), type.get_type_name(), fast::TOPIC_QOS_DEFAULT);
  }
  fast::DataReader* reader(fast::Topic* topic, const dds::Quality& quality) {
    fast::DataReaderQos qos = fast::DATAREADER_QOS_DEFAULT;
    set(qos, quality);
    return subscriber_->create_datareader(topic, qos);
  }
  fast::DataWriter* writer(fast::Topic* topic, const dds::Quality& quality) {
    fast::DataWriterQos qos = fast::DATAWRITER_QOS_DEFAULT;
    set(qos, quality);
    qos.publish_mode().kind = fast::ASYNCHRONOUS_PUBLISH_MODE;  // large samples are sent in fragments
    return publisher_->create_datawriter(topic, qos);
  }

 private:
  template <class Qos>
  static void set(Qos& qos, const dds::Quality& quality) {
    qos.reliability().kind = quality.reliable ? fast::RELIABLE_RELIABILITY_QOS : fast::BEST_EFFORT_RELIABILITY_QOS;
    qos.durability().kind = quality.latched ? fast::TRANSIENT_LOCAL_DURABILITY_QOS : fast::VOLATILE_DURABILITY_QOS;
    qos.history().kind = fast::KEEP_LAST_HISTORY_QOS;
    qos.history().depth = quality.depth;
    qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  }

  fast::DomainParticipant* participant_;
  fast::Publisher* publisher_;
  fast::Subscriber* subscriber_;
};

/// A message of ours goes to Fast DDS, which decodes it, and what it decoded comes back as Fast DDS encodes it.
template <class Theirs, class Support, ros::Message Ours>
Theirs exchange(FastDds& peer, const dds::Participant& participant, const Ours& message) {
  const std::string type(Ours::kType);
  const std::string name = type.substr(type.rfind('/'));
  SCOPED_TRACE(type);
  fast::DataReader* const from_us = peer.reader(peer.topic<Support>("/out" + name), kReliable);
  fast::DataWriter* const to_us = peer.writer(peer.topic<Support>("/in" + name), kReliable);
  dds::Writer writer(participant, "/out" + name, type, kReliable, kPatience);
  dds::Reader reader(participant, "/in" + name, type, {.reliable = false, .latched = false, .depth = 10});
  EXPECT_TRUE(eventually([&] { return writer.readers() == 1 && reader.writers() == 1; })) << "they do not match";
  fast::SubscriptionMatchedStatus matched;
  EXPECT_TRUE(eventually([&] {
    return from_us->get_subscription_matched_status(matched) == ReturnCode_t::RETCODE_OK && matched.current_count == 1;
  }));
  fast::PublicationMatchedStatus matched_by_us;
  EXPECT_TRUE(eventually([&] {
    return to_us->get_publication_matched_status(matched_by_us) == ReturnCode_t::RETCODE_OK &&
           matched_by_us.current_count == 1;
  }));

  std::vector<std::uint8_t> sent = ros::to_cdr(message);
  writer.write(sent);
  Theirs theirs;
  fast::SampleInfo info;
  EXPECT_TRUE(eventually([&] { return from_us->take_next_sample(&theirs, &info) == ReturnCode_t::RETCODE_OK; }))
      << "Fast DDS reads nothing";
  EXPECT_TRUE(to_us->write(&theirs));
  std::vector<dds::Sample> samples;
  EXPECT_TRUE(eventually([&] {
    reader.take(samples);
    return !samples.empty();
  })) << "nothing comes back";
  if (samples.empty()) return theirs;
  EXPECT_EQ(ros::from_cdr<Ours>(samples[0].bytes()), message);
  sent.resize((sent.size() + 3) / 4 * 4);
  EXPECT_EQ(samples[0].bytes(), sent) << "the bytes of Fast DDS are others";
  return theirs;
}

template <class Theirs, class Support, ros::Message Ours>
void exchange_filled(FastDds& peer, const dds::Participant& participant) {
  Ours message;
  ros_test::Filler().fill(message);
  exchange<Theirs, Support>(peer, participant, message);
}

class FastDdsPeer : public ::testing::Test {
 protected:
  dds::Participant ours_{{test::own_domain(), "lo"}};
  FastDds peer_;
};

TEST_F(FastDdsPeer, EveryMessageGoesBothWays) {
#define WAYMARK_EXCHANGE(package, name) \
  exchange_filled<package::msg::name, package::msg::name##PubSubType, ros::package::name>(peer_, ours_)
  WAYMARK_EXCHANGE(sensor_msgs, Imu);
  WAYMARK_EXCHANGE(sensor_msgs, MagneticField);
  WAYMARK_EXCHANGE(sensor_msgs, NavSatFix);
  WAYMARK_EXCHANGE(sensor_msgs, LaserScan);
  WAYMARK_EXCHANGE(sensor_msgs, PointCloud2);
  WAYMARK_EXCHANGE(sensor_msgs, Image);
  WAYMARK_EXCHANGE(sensor_msgs, CompressedImage);
  WAYMARK_EXCHANGE(sensor_msgs, CameraInfo);
  WAYMARK_EXCHANGE(sensor_msgs, JointState);
  WAYMARK_EXCHANGE(nav_msgs, Odometry);
  WAYMARK_EXCHANGE(nav_msgs, Path);
  WAYMARK_EXCHANGE(nav_msgs, OccupancyGrid);
  WAYMARK_EXCHANGE(geometry_msgs, PoseStamped);
  WAYMARK_EXCHANGE(geometry_msgs, PoseWithCovarianceStamped);
  WAYMARK_EXCHANGE(geometry_msgs, TwistStamped);
  WAYMARK_EXCHANGE(geometry_msgs, TwistWithCovarianceStamped);
  WAYMARK_EXCHANGE(tf2_msgs, TFMessage);
  WAYMARK_EXCHANGE(rosgraph_msgs, Clock);
  WAYMARK_EXCHANGE(map_msgs, OccupancyGridUpdate);
  WAYMARK_EXCHANGE(octomap_msgs, Octomap);
  WAYMARK_EXCHANGE(visualization_msgs, MarkerArray);
  WAYMARK_EXCHANGE(diagnostic_msgs, DiagnosticArray);
#undef WAYMARK_EXCHANGE
}

TEST_F(FastDdsPeer, ReadsTheValuesUnderTheirNames) {
  ros::sensor_msgs::Imu imu;
  imu.header = {{1'700'000'000, 5}, "imu_link"};
  imu.orientation = {0.1, 0.2, 0.3, 0.4};
  imu.angular_velocity.z = 0.5;
  imu.linear_acceleration_covariance[8] = 0.6;
  const auto read = exchange<sensor_msgs::msg::Imu, sensor_msgs::msg::ImuPubSubType>(peer_, ours_, imu);
  EXPECT_EQ(read.header().stamp().sec(), 1'700'000'000);
  EXPECT_EQ(read.header().frame_id(), "imu_link");
  EXPECT_EQ(read.orientation().w(), 0.4);
  EXPECT_EQ(read.angular_velocity().z(), 0.5);
  EXPECT_EQ(read.linear_acceleration_covariance()[8], 0.6);

  ros::nav_msgs::Odometry odometry;
  odometry.child_frame_id = "base_link";
  odometry.pose.pose.position.y = 2.0;
  odometry.twist.covariance[35] = 3.0;
  const auto moved = exchange<nav_msgs::msg::Odometry, nav_msgs::msg::OdometryPubSubType>(peer_, ours_, odometry);
  EXPECT_EQ(moved.child_frame_id(), "base_link");
  EXPECT_EQ(moved.pose().pose().position().y(), 2.0);
  EXPECT_EQ(moved.twist().covariance()[35], 3.0);
}

TEST_F(FastDdsPeer, APictureInManyFragmentsGoesBothWays) {
  ros::sensor_msgs::Image image;
  image.height = 480;
  image.width = 640;
  image.encoding = "bgr8";
  image.step = 3 * image.width;
  image.data.resize(std::size_t{image.step} * image.height);
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = static_cast<std::uint8_t>(i * 7 / 3);
  const auto read = exchange<sensor_msgs::msg::Image, sensor_msgs::msg::ImagePubSubType>(peer_, ours_, image);
  EXPECT_EQ(read.data(), image.data);
}

TEST_F(FastDdsPeer, GetsTheMapThatWasPublishedBeforeItCame) {
  dds::Writer writer(ours_, "/map", std::string(ros::nav_msgs::OccupancyGrid::kType), kLatched, kPatience);
  ros::nav_msgs::OccupancyGrid grid;
  grid.data = {0, 100, -1};
  writer.write(ros::to_cdr(grid));
  fast::DataReader* const reader = peer_.reader(peer_.topic<nav_msgs::msg::OccupancyGridPubSubType>("/map"), kLatched);
  nav_msgs::msg::OccupancyGrid read;
  fast::SampleInfo info;
  EXPECT_TRUE(eventually([&] { return reader->take_next_sample(&read, &info) == ReturnCode_t::RETCODE_OK; }));
  EXPECT_EQ(read.data(), grid.data);
}

TEST_F(FastDdsPeer, ItsStaticTransformsReachAReaderThatComesLater) {
  fast::DataWriter* const writer =
      peer_.writer(peer_.topic<tf2_msgs::msg::TFMessagePubSubType>("/tf_static"), kLatched);
  tf2_msgs::msg::TFMessage message;
  message.transforms().resize(1);
  message.transforms()[0].child_frame_id("laser");
  EXPECT_TRUE(writer->write(&message));
  dds::Reader reader(ours_, "/tf_static", std::string(ros::tf2_msgs::TFMessage::kType), kLatched);
  std::vector<dds::Sample> samples;
  EXPECT_TRUE(eventually([&] {
    reader.take(samples);
    return !samples.empty();
  }));
  ASSERT_EQ(samples.size(), 1U);
  EXPECT_EQ(ros::from_cdr<ros::tf2_msgs::TFMessage>(samples[0].bytes()).transforms.at(0).child_frame_id, "laser");
}

}  // namespace
}  // namespace waymark
