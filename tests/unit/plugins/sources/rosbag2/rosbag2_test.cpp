// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <sqlite3.h>

#include "plugins/shared/compression/zstd_frame.hpp"
#include "unit/plugins/shared/cdr/timed_cloud.hpp"
#include "unit/plugins/sources/mcap/mcap_fixture.hpp"

namespace waymark::rosbag2_test {
namespace {

using mcap_test::odometry;
using mcap_test::twist;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using Bytes = std::vector<std::uint8_t>;

constexpr std::int64_t kSecond = 1'000'000'000;

/// Writes a .db3 as rosbag2 does. The tables are those of early versions, without definitions.
class Db3Writer {
 public:
  explicit Db3Writer(const std::filesystem::path& file) {
    EXPECT_EQ(::sqlite3_open(file.c_str(), &database_), SQLITE_OK);
    run("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,"
        " serialization_format TEXT NOT NULL)");
    run("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,"
        " data BLOB NOT NULL)");
    run("CREATE INDEX timestamp_idx ON messages (timestamp ASC)");
  }
  ~Db3Writer() { ::sqlite3_close(database_); }
  Db3Writer(const Db3Writer&) = delete;
  Db3Writer& operator=(const Db3Writer&) = delete;

  void topic(int id, const std::string& name, std::string_view type) {
    run("INSERT INTO topics VALUES(" + std::to_string(id) + ", '" + name + "', '" + std::string(type) + "', 'cdr')");
  }
  void add(int topic, std::int64_t recorded, const Bytes& message) {
    sqlite3_stmt* insert = nullptr;
    ::sqlite3_prepare_v2(database_, "INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)", -1, &insert,
                         nullptr);
    ::sqlite3_bind_int(insert, 1, topic);
    ::sqlite3_bind_int64(insert, 2, recorded);
    ::sqlite3_bind_blob(insert, 3, message.data(), static_cast<int>(message.size()), SQLITE_TRANSIENT);
    EXPECT_EQ(::sqlite3_step(insert), SQLITE_DONE);
    ::sqlite3_finalize(insert);
  }
  void run(const std::string& statement) {
    EXPECT_EQ(::sqlite3_exec(database_, statement.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << statement;
  }

 private:
  sqlite3* database_ = nullptr;
};

class Rosbag2 : public mcap_test::SourceTest {
 protected:
  Rosbag2() : SourceTest("rosbag2") { std::filesystem::create_directory(folder_ / "bag"); }

  /// Twists 1 to 5 s, speeds as the seconds.
  void write_db3(const std::string& name, int first, int last, bool compressed = false) const {
    Db3Writer file(folder_ / name);
    file.topic(1, "/other", "std_msgs/msg/String");
    file.topic(7, "/twist", "geometry_msgs/msg/TwistStamped");
    for (int k = last; k >= first; --k) {
      const Bytes message = ros::to_cdr(twist(k * kSecond, k));
      file.add(7, k * kSecond, compressed ? compression::compress_zstd(message, 3) : message);
    }
  }
  void write_mcap(const std::string& name, int first, int last) const {
    mcap_test::TopicWriter file;
    for (int k = first; k <= last; ++k) file.add("/twist", k * kSecond, twist(k * kSecond, k));
    write(name, file.finish());
  }
  void write_metadata(const std::string& paths, const std::string& more = "") const {
    const std::string text = "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: sqlite3\n" + more +
                             "  relative_file_paths:\n" + paths;
    write("bag/metadata.yaml", {text.begin(), text.end()});
  }
  std::vector<double> speeds(const std::string& more = "file: bag") const {
    std::vector<double> speeds;
    for (const Measurement& m : read_all(*make("{ topic: /twist, sensor: a }", more)))
      speeds.push_back(m.as<BodyTwist>().v_x_mps);
    return speeds;
  }
};

TEST_F(Rosbag2, ADatabaseAloneIsABag) {
  write_db3("a.db3", 1, 5);
  const auto source = make("{ topic: /twist, sensor: a }", "file: a.db3");
  const auto all = read_all(*source);
  ASSERT_THAT(all, SizeIs(5));
  EXPECT_EQ(all[1].arrival, Time(std::chrono::seconds(2)));
  EXPECT_EQ(all[1].as<BodyTwist>().v_x_mps, 2.0);
  EXPECT_EQ(source->progress(), 1.0);
}

TEST_F(Rosbag2, CloudsHaveTheTimesOfTheirPoints) {
  {
    Db3Writer file(folder_ / "a.db3");
    file.topic(1, "/points", "sensor_msgs/msg/PointCloud2");
    auto cloud = ros_test::timed_cloud(mcap_test::header(kSecond), "time", ros_test::kFloat32, {-0.25, 0.0});
    file.add(1, kSecond, ros::to_cdr(cloud));
    cloud.header = mcap_test::header(2 * kSecond);
    cloud.point_step = 0xffff'ffff;
    file.add(1, 2 * kSecond, ros::to_cdr(cloud));
  }
  rig_ = Rig({{"lidar", "waymark/PointCloud@1", std::nullopt}});
  const auto source = make("{ topic: /points, sensor: lidar }", "file: a.db3\nmax_bad_records: 1");
  const auto all = read_all(*source);
  ASSERT_THAT(all, SizeIs(1));
  EXPECT_EQ(all[0].as<PointCloud>().points_m.at(1), Eigen::Vector3f(1.0f, 2.0f, 3.0f));
  EXPECT_EQ(all[0].as<PointCloud>().offsets_s, (std::vector<float>{-0.25f, 0.0f}));
  EXPECT_THAT(source->bad_records().at(0).reason, HasSubstr("a cloud of 2 x 1 points of 4294967295 bytes"));
}

TEST_F(Rosbag2, PartsOfABagAreReadAsOne) {
  write_db3("bag/bag_0.db3", 1, 3);
  write_mcap("bag/bag_1.mcap", 4, 6);
  write_metadata("    - bag_0.db3\n    - bag_1.mcap\n");
  EXPECT_THAT(speeds(), testing::ElementsAre(1, 2, 3, 4, 5, 6));
  write_metadata("    - bag/bag_1.mcap\n");
  EXPECT_THAT(speeds(), testing::ElementsAre(4, 5, 6)) << "old bags have their folder's name in front";
}

TEST_F(Rosbag2, WithoutMetadataAllPartsCount) {
  write_db3("bag/bag_9.db3", 1, 3);
  write_db3("bag/bag_10.db3", 3, 4);
  EXPECT_THAT(speeds(), testing::ElementsAre(1, 2, 3, 3, 4));
}

TEST_F(Rosbag2, CompressedFilesAreUnpacked) {
  write_db3("plain.db3", 1, 3);
  std::ifstream in(folder_ / "plain.db3", std::ios::binary);
  const Bytes content{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  write("bag/bag_0.db3.zstd", compression::compress_zstd(content, 3));
  write_metadata("    - bag_0.db3\n", "  compression_format: zstd\n  compression_mode: FILE\n");
  EXPECT_THAT(speeds(), testing::ElementsAre(1, 2, 3));
  auto damaged = compression::compress_zstd(content, 3);
  damaged.resize(damaged.size() / 2);
  write("bag/bag_0.db3.zstd", damaged);
  EXPECT_THAT(error_of("{ topic: /twist, sensor: a }", "file: bag"), HasSubstr("is damaged: it ends early"));
}

TEST_F(Rosbag2, AFewBytesThatUnpackToGigabytesAreRefused) {
  write("a.db3.zst", compression::compress_zstd(Bytes(std::size_t{64} << 20), 3));
  EXPECT_THAT(error_of("{ topic: /twist, sensor: a }", "file: a.db3.zst"),
              HasSubstr("a.db3.zst: unpacks to more than 1000 times its size"));
}

TEST_F(Rosbag2, CompressedMessagesAreUnpacked) {
  write_db3("bag/bag_0.db3", 1, 3, true);
  write_metadata("    - bag_0.db3\n", "  compression_format: zstd\n  compression_mode: MESSAGE\n");
  EXPECT_THAT(speeds(), testing::ElementsAre(1, 2, 3));
}

TEST_F(Rosbag2, DefinitionsAreCheckedWhereTheyAreRecorded) {
  {
    Db3Writer file(folder_ / "a.db3");
    file.topic(1, "/twist", "geometry_msgs/msg/TwistStamped");
    file.run(
        "CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT, encoding TEXT,"
        " encoded_message_definition TEXT)");
    file.run("INSERT INTO message_definitions VALUES(1, 'geometry_msgs/msg/TwistStamped', 'ros2msg', 'float32 v')");
  }
  EXPECT_THAT(error_of("{ topic: /twist, sensor: a }", "file: a.db3"), HasSubstr("whose definition is another one"));
}

TEST_F(Rosbag2, WhatIsNoBagIsAnError) {
  const std::string channel = "{ topic: /twist, sensor: a }";
  write("a.db3", {'n', 'o', 't', 'h', 'i', 'n', 'g'});
  EXPECT_THAT(error_of(channel, "file: a.db3"), HasSubstr("a.db3: is not a bag of ROS 2: file is not a database"));
  EXPECT_THAT(error_of(channel, "file: none.db3"), HasSubstr("none.db3: cannot be read"));
  EXPECT_THAT(error_of(channel, "file: bag"), HasSubstr("bag: has no parts (.db3 or .mcap)"));
  write_metadata("    - bag_0.db3\n");
  EXPECT_THAT(error_of(channel, "file: bag"), HasSubstr("names the part bag_0.db3, which is not there"));
  write("bag/metadata.yaml", {'a', ':', ' ', '['});
  EXPECT_THAT(error_of(channel, "file: bag"), HasSubstr("metadata.yaml:1:"));
  for (const std::string& hostile : {std::string(200'000, '['), std::string(",5"), std::string("42")}) {
    write("bag/metadata.yaml", {hostile.begin(), hostile.end()});
    EXPECT_THAT(error_of(channel, "file: bag"), HasSubstr("metadata.yaml"));
  }
  write_metadata("    - bag_0.db3\n", "  compression_format: lzma\n");
  EXPECT_THAT(error_of(channel, "file: bag"), HasSubstr("the compression \"lzma\" is not known"));
  { Db3Writer file(folder_ / "b.db3"); }
  EXPECT_THAT(error_of(channel, "file: b.db3"), HasSubstr("there is no topic in the bag"));
}

TEST_F(Rosbag2, AViewInPlaceOfATableIsRefused) {
  {
    Db3Writer file(folder_ / "a.db3");
    file.topic(1, "/twist", "geometry_msgs/msg/TwistStamped");
    file.run("DROP TABLE messages");
    file.run(
        "CREATE VIEW messages AS WITH RECURSIVE c(id) AS (SELECT 1 UNION ALL SELECT id + 1 FROM c)"
        " SELECT id, 1 AS topic_id, id AS timestamp, x'' AS data FROM c");
  }
  EXPECT_THAT(error_of("{ topic: /twist, sensor: a }", "file: a.db3"), HasSubstr("there is no table \"messages\""));
}

TEST_F(Rosbag2, ADamagedDatabaseEndsInABadRecord) {
  write_db3("plain.db3", 1, 2000);
  std::ifstream in(folder_ / "plain.db3", std::ios::binary);
  Bytes content{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  content.resize(content.size() / 2 / 4096 * 4096);
  write("a.db3", content);
  try {
    const auto source = make("{ topic: /twist, sensor: a }", "file: a.db3\nmax_bad_records: 5");
    EXPECT_LT(read_all(*source).size(), 2000U);
    EXPECT_THAT(source->bad_records(), testing::Not(IsEmpty()));
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr("malformed"));
  }
}

}  // namespace
}  // namespace waymark::rosbag2_test
