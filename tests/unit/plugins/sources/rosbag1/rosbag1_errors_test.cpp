// SPDX-License-Identifier: Apache-2.0
// Bags that are damaged, end early or do not hold what the YAML asks for.
#include <gmock/gmock.h>

#include <algorithm>

#include "rosbag1_fixture.hpp"

namespace waymark {
namespace {

using namespace rosbag1_test;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StartsWith;

class Rosbag1Errors : public Rosbag1Test {
 protected:
  /// Three chunks with ten messages each, no one alike.
  static BagWriter thirty(const std::string& compression) {
    BagWriter bag;
    const auto x = bag.connect("/x", kTwist);
    for (int k = 1; k <= 30; ++k) {
      bag.add(x, k, twist_message(k, k));
      if (k % 10 == 0) bag.end_chunk(compression);
    }
    return bag;
  }

  template <class E = ConfigError>
  std::string error_of(const std::string& channels, const std::string& more = "file: a.bag") const {
    try {
      read_all(*make(channels, more));
    } catch (const E& error) {
      return error.what();
    }
    ADD_FAILURE() << "no error";
    return "";
  }

  /// Reads as far as it goes. Any error must be one of ours.
  std::vector<double> read_what_there_is(std::size_t* bad = nullptr) const {
    std::vector<double> speeds;
    try {
      const auto source = make("{ topic: /x, sensor: a }", "file: a.bag\nmax_bad_records: 1000");
      while (const auto m = source->next()) speeds.push_back(m->as<BodyTwist>().v_x_mps);
      if (bad != nullptr) *bad = source->bad_records().size();
    } catch (const Error&) {
    }
    return speeds;
  }
};

TEST_F(Rosbag1Errors, AnUnknownTopicIsAnswered) {
  BagWriter bag;
  const auto imu = bag.connect("/imu/data", kImu);
  bag.connect("/fix", kFix);
  bag.add(imu, 1, imu_message(1, {}));
  bag.end_chunk();
  write_bag(bag);
  EXPECT_THAT(error_of("{ topic: /imu/dat, sensor: a }"),
              AllOf(HasSubstr("channels[0].topic: there is no topic \"/imu/dat\"; did you mean \"/imu/data\"?"),
                    HasSubstr("/fix (sensor_msgs/NavSatFix, 0), /imu/data (sensor_msgs/Imu, 1)")));
}

TEST_F(Rosbag1Errors, TypesThatCannotBeReadAreRefused) {
  BagWriter bag;
  const auto imu = bag.connect("/imu", {"sensor_msgs/Imu", "00000000000000000000000000000000"});
  bag.connect("/text", {"std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1"});
  bag.connect("/both", kImu);
  bag.connect("/both", kFix);
  bag.add(imu, 1, "");
  bag.end_chunk();
  write_bag(bag);
  EXPECT_THAT(error_of("{ topic: /imu, sensor: a }"),
              HasSubstr("md5 sum 00000000000000000000000000000000, but 6a62c6daae103f4ff57a132d6f95cec2 is expected"));
  EXPECT_THAT(error_of("{ topic: /text, sensor: a }"), AllOf(HasSubstr("std_msgs/String"), HasSubstr("nav_msgs/Odom")));
  EXPECT_THAT(error_of("{ topic: /both, sensor: a }"), HasSubstr("2 types"));
}

TEST_F(Rosbag1Errors, ChannelsMustFitTheirSensors) {
  BagWriter bag;
  bag.connect("/x", kOdometry);
  bag.end_chunk();
  write_bag(bag);
  EXPECT_THAT(error_of("{ topic: /x, sensor: c }"), HasSubstr("there is no sensor \"c\""));
  EXPECT_THAT(error_of("{ topic: /x, sensor: lidar }"), HasSubstr("takes waymark/LaserScan@1"));
  EXPECT_THAT(error_of("{ topic: /x, sensor: a, payload: GnssFix }"),
              HasSubstr("GnssFix cannot be made of nav_msgs/Odometry; BodyTwist, Height or PoseIncrement is expected"));
  EXPECT_THAT(error_of("{ topic: /x, sensor: a }, { topic: /x, sensor: b }"), HasSubstr("two sensors on one input"));
  EXPECT_THAT(error_of("{ topic: /x, sensor: a, stamps: header }"), HasSubstr("did you mean \"stamp\"?"));
  EXPECT_THAT(error_of(""), HasSubstr("the list is empty"));
}

TEST_F(Rosbag1Errors, OtherFilesAreNoBags) {
  write("a.bag", "#ROSBAG V1.2\n");
  EXPECT_THAT(error_of("{ topic: /x, sensor: a }"), AllOf(HasSubstr("a.bag:byte 0: begins with \"#ROSBAG V1.2.\"")));
  write("a.bag", "");
  EXPECT_THAT(error_of("{ topic: /x, sensor: a }"), HasSubstr("begins with \"\""));
  EXPECT_THAT(error_of("{ topic: /x, sensor: a }", "file: nowhere.bag"), HasSubstr("nowhere.bag: cannot be read"));
  EXPECT_THAT(error_of("{ topic: /x, sensor: a }", "file: ."), HasSubstr("is a folder"));
  BagWriter bag = thirty("none");
  std::string bytes = bag.closed();
  bytes.replace(bytes.find("compression=none"), 16, "compression=zstd");
  write("a.bag", bytes);
  EXPECT_THAT(error_of("{ topic: /x, sensor: a }"), HasSubstr("the compression \"zstd\" is not known"));
}

TEST_F(Rosbag1Errors, ABagThatWasNeverClosedIsReadToItsEnd) {
  for (const std::string compression : {"none", "bz2", "lz4"}) {
    write("a.bag", thirty(compression).unclosed());
    std::size_t bad = 99;
    EXPECT_THAT(read_what_there_is(&bad), SizeIs(30));
    EXPECT_EQ(bad, 0U);
  }
}

TEST_F(Rosbag1Errors, ABagThatEndsEarlyIsReadAsFarAsItGoes) {
  const std::string bytes = thirty("none").unclosed();
  // Within the last chunk, behind six of its messages.
  const std::size_t last_message = bytes.rfind(twist_message(27, 27));
  ASSERT_NE(last_message, std::string::npos);
  write("a.bag", bytes.substr(0, last_message + 3));
  const auto source = make("{ topic: /x, sensor: a }", "file: a.bag\nmax_bad_records: 1");
  EXPECT_THAT(read_all(*source), SizeIs(26));
  ASSERT_THAT(source->bad_records(), SizeIs(1));
  EXPECT_THAT(source->bad_records()[0].place, StartsWith((folder_ / "a.bag:byte ").string()));
  EXPECT_THAT(source->bad_records()[0].reason, HasSubstr("the bag ends early"));
  EXPECT_THAT(error_of<DataError>("{ topic: /x, sensor: a }"), HasSubstr("max_bad_records allows 0"));
}

/// Every byte of a bag as it is; of compressed ones, whose records are the same, every fifth.
std::size_t stride(const std::string& compression) { return compression == "none" ? 1 : 5; }

TEST_F(Rosbag1Errors, NoPlaceToEndDoesHarm) {
  for (const std::string compression : {"none", "bz2", "lz4"}) {
    const std::string bytes = thirty(compression).closed();
    std::size_t most = 0;
    const std::size_t step = stride(compression);
    for (std::size_t length = bytes.size() % step; length <= bytes.size(); length += step) {
      write("a.bag", std::string_view(bytes).substr(0, length));
      const std::vector<double> speeds = read_what_there_is();
      for (std::size_t i = 0; i < speeds.size(); ++i) ASSERT_EQ(speeds[i], static_cast<double>(i + 1));
      ASSERT_GE(speeds.size(), most) << compression << " " << length;
      most = speeds.size();
    }
    EXPECT_EQ(most, 30U);
  }
}

TEST_F(Rosbag1Errors, NoWrongByteDoesHarm) {
  for (const std::string compression : {"none", "bz2", "lz4"}) {
    const std::string bytes = thirty(compression).closed();
    for (std::size_t at = 0; at < bytes.size(); at += stride(compression)) {
      std::string damaged = bytes;
      damaged[at] = static_cast<char>(damaged[at] ^ (at % 2 == 0 ? 0xff : 0x01));
      write("a.bag", damaged);
      EXPECT_LE(read_what_there_is().size(), 30U);
    }
  }
}

TEST_F(Rosbag1Errors, ADamagedChunkIsLeftOut) {
  std::string bytes = thirty("bz2").closed();
  const std::size_t second = bytes.find("BZh", bytes.find("BZh") + 1);
  bytes[second + 60] = static_cast<char>(bytes[second + 60] ^ 0x55);
  write("a.bag", bytes);
  std::size_t bad = 0;
  const auto speeds = read_what_there_is(&bad);
  EXPECT_THAT(speeds, SizeIs(20));
  EXPECT_EQ(bad, 1U);
  EXPECT_THAT(error_of<DataError>("{ topic: /x, sensor: a }"), HasSubstr("a chunk is damaged"));
}

TEST_F(Rosbag1Errors, ABagThatBreaksOffBeforeItsTopicsSaysWhere) {
  write("a.bag", "#ROSBAG V2.0\n\xff\xff\xff\x7f");
  EXPECT_THAT(error_of("{ topic: /x, sensor: a }"),
              AllOf(HasSubstr("there is no topic in the bag"), HasSubstr("a.bag:byte 13"),
                    HasSubstr("its header would have 2147483647 bytes")));
}

// Equal bytes: some hundred compressed ones unpack to 40 MiB, though no compression of bags does as well on messages.
TEST_F(Rosbag1Errors, AChunkThatUnpacksToFarMoreThanItsBytesIsRefused) {
  BagWriter bag;
  const auto x = bag.connect("/x", kTwist);
  bag.add(x, 1, twist_message(1, 1));
  bag.add(x, 2, std::string(40U << 20, ' '));
  bag.end_chunk("bz2");
  write("a.bag", bag.closed());
  EXPECT_THAT(error_of<Error>("{ topic: /x, sensor: a }"), AllOf(HasSubstr("a.bag"), HasSubstr("would unpack to")));
}

TEST_F(Rosbag1Errors, ChunksThatOverlapInTimeAreBoundedTogether) {
  BagWriter bag;
  const auto x = bag.connect("/x", kTwist);
  const auto y = bag.connect("/y", kTwist);
  for (int chunk = 0; chunk < 6; ++chunk) {
    bag.add(x, 1, twist_message(1, 1));
    bag.add(y, 100, std::string(30U << 20, ' '));
    bag.add(x, 100, twist_message(100, 1));
    bag.end_chunk("bz2");
  }
  write("a.bag", bag.closed());
  EXPECT_THAT(error_of<DataError>("{ topic: /x, sensor: a }"), HasSubstr("overlap in time unpack to more than"));
}

TEST_F(Rosbag1Errors, AMessageThatIsNoneIsSkipped) {
  EXPECT_THAT(one(kTwist, twist_message(1, 1) + "x"), IsEmpty());
  EXPECT_THAT(bad_, HasSubstr("/x: 1 bytes are left behind a geometry_msgs/TwistStamped"));
  EXPECT_THAT(one(kTwist, twist_message(1, 1).substr(0, 50)), IsEmpty());
  EXPECT_THAT(bad_, HasSubstr("/x: ends early"));
  EXPECT_THAT(one(kTwist, twist_message(1, std::numeric_limits<double>::infinity())), IsEmpty());
  EXPECT_THAT(bad_, HasSubstr("not finite"));
  EXPECT_THAT(one(kImu, imu_message(1, {.q_variance = -1.0, .w_variance = -1.0})), IsEmpty());
  EXPECT_THAT(bad_, HasSubstr("neither an angular velocity nor an orientation"));
}

}  // namespace
}  // namespace waymark
