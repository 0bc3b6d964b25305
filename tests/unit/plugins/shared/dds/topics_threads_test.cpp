// SPDX-License-Identifier: Apache-2.0
// Readers and writers of one process, which CycloneDDS connects without a network; tests/peers/fast_dds has the
// network.
#include <gmock/gmock.h>

#include <chrono>
#include <string>
#include <vector>

#include "dds_domain.hpp"
#include "live_source.hpp"
#include "plugins/shared/dds/reader.hpp"
#include "plugins/shared/dds/writer.hpp"
#include "waymark/base/error.hpp"

namespace waymark::dds {
namespace {

using test::eventually;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::string kType = "std_msgs/msg/Header";
constexpr Quality kBestEffort{.reliable = false};
constexpr Quality kReliable{};
constexpr Quality kLatched{.reliable = true, .latched = true, .depth = 1};
constexpr std::chrono::milliseconds kPatience{100};

std::vector<std::uint8_t> message(std::uint8_t content, std::size_t size = 12) {
  std::vector<std::uint8_t> bytes(size, content);
  bytes[0] = bytes[2] = bytes[3] = 0;
  bytes[1] = 1;
  return bytes;
}

class DdsTopics : public ::testing::Test {
 protected:
  std::vector<Sample> wait_for(Reader& reader, std::size_t count) {
    std::vector<Sample> samples;
    eventually([&] {
      reader.take(samples);
      return samples.size() >= count;
    });
    return samples;
  }
  static void connect(const Reader& reader, std::size_t writers = 1) {
    ASSERT_TRUE(eventually([&] { return reader.writers() == writers; }));
  }

  DomainSettings settings_{test::own_domain(), "lo"};
  Participant ours_{settings_, 1000};
  Participant theirs_{settings_};
};

TEST_F(DdsTopics, ASampleArrivesAsItWasWrittenWithItsTime) {
  Reader reader(ours_, "/a", kType, kReliable);
  Writer writer(theirs_, "/a", kType, kReliable, kPatience);
  connect(reader);
  writer.write(message(7, 13), Time{Duration{1'700'000'000'123'456'789}});
  const auto samples = wait_for(reader, 1);
  ASSERT_EQ(samples.size(), 1U);
  auto expected = message(7, 13);
  expected.resize(16);
  EXPECT_EQ(samples[0].bytes(), expected);
  EXPECT_EQ(samples[0].written_ns(), 1'700'000'000'123'456'789);
}

TEST_F(DdsTopics, WhoComesLaterGetsTheLastOfALatchedTopic) {
  Writer writer(theirs_, "/map", kType, kLatched, kPatience);
  writer.write(message(1));
  writer.write(message(2));
  Reader reader(ours_, "/map", kType, kLatched);
  const auto samples = wait_for(reader, 1);
  ASSERT_EQ(samples.size(), 1U);
  EXPECT_EQ(samples[0].bytes(), message(2));
}

TEST_F(DdsTopics, ABestEffortReaderGetsAReliableWriterButNotTheOtherWayRound) {
  Reader modest(ours_, "/a", kType, kBestEffort);
  Reader strict(ours_, "/b", kType, kReliable);
  Writer reliable(theirs_, "/a", kType, kReliable, kPatience);
  Writer best_effort(theirs_, "/b", kType, kBestEffort, kPatience);
  connect(modest);
  EXPECT_TRUE(eventually([&] { return strict.refused_writers() == 1; }));
  EXPECT_EQ(strict.writers(), 0U);
}

TEST_F(DdsTopics, OfASampleThatIsTooLargeOnlyItsSizeArrives) {
  Reader reader(ours_, "/a", kType, kReliable);
  Writer writer(theirs_, "/a", kType, kReliable, kPatience);
  connect(reader);
  writer.write(message(7, 1004));
  const auto samples = wait_for(reader, 1);
  ASSERT_EQ(samples.size(), 1U);
  EXPECT_TRUE(samples[0].bytes().empty());
  EXPECT_EQ(samples[0].size(), 1004U);
}

TEST_F(DdsTopics, SamplesOfSeveralTopicsHaveTheOrderOfTheirArrival) {
  Reader a(ours_, "/a", kType, kReliable);
  Reader b(ours_, "/b", kType, kReliable);
  Writer to_a(theirs_, "/a", kType, kReliable, kPatience);
  Writer to_b(theirs_, "/b", kType, kReliable, kPatience);
  connect(a);
  connect(b);
  to_b.write(message(1));
  to_a.write(message(2));
  to_b.write(message(3));
  const auto of_a = wait_for(a, 1);
  const auto of_b = wait_for(b, 2);
  ASSERT_EQ(of_a.size() + of_b.size(), 3U);
  EXPECT_LT(of_b[0].order(), of_a[0].order());
  EXPECT_LT(of_a[0].order(), of_b[1].order());
}

TEST_F(DdsTopics, SamplesThatNewerOnesReplaceAreCountedAsLost) {
  Reader reader(ours_, "/a", kType, {.reliable = true, .latched = false, .depth = 3});
  Writer writer(theirs_, "/a", kType, kReliable, kPatience);
  connect(reader);
  for (std::uint8_t i = 0; i < 10; ++i) writer.write(message(i));
  EXPECT_TRUE(eventually([&] { return reader.lost() == 7; })) << reader.lost();
  EXPECT_EQ(wait_for(reader, 3).size(), 3U);
  EXPECT_EQ(reader.lost(), 7U);
}

TEST_F(DdsTopics, TheTypesOfOthersOnATopicAreKnown) {
  Writer writer(theirs_, "/a", "sensor_msgs/msg/Imu", kReliable, kPatience);
  EXPECT_TRUE(eventually([&] { return !ours_.types_on("/a", true).empty(); }));
  EXPECT_THAT(ours_.types_on("/a", true), ElementsAre("sensor_msgs/msg/Imu"));
  EXPECT_TRUE(ours_.types_on("/a", false).empty());
}

TEST_F(DdsTopics, WaitingEndsWithASampleOrWhenItIsStopped) {
  Reader reader(ours_, "/a", kType, kReliable);
  Writer writer(theirs_, "/a", kType, kReliable, kPatience);
  connect(reader);
  Wait wait(ours_);
  wait.add(reader);
  writer.write(message(1));
  const auto begin = std::chrono::steady_clock::now();
  wait.wait(std::chrono::seconds(20));
  EXPECT_EQ(wait_for(reader, 1).size(), 1U);
  std::thread other([&] { wait.stop(); });
  wait.wait(std::chrono::seconds(20));
  other.join();
  wait.wait(std::chrono::seconds(20));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(15));
}

TEST_F(DdsTopics, OneInterfaceIsUsedByAllPluginsOfADomain) {
  try {
    Participant other({settings_.id, "auto"});
    FAIL() << "it is not refused";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("interface auto"));
    EXPECT_THAT(error.what(), HasSubstr("through lo"));
  }
}

TEST(DdsParticipant, AnInterfaceThatDoesNotExistIsNamed) {
  try {
    Participant other({test::own_domain(), "nowhere7"});
    FAIL() << "it is not refused";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("nowhere7"));
  }
}

TEST(DdsParticipant, ADomainCanBeUsedAgainAfterItsLastParticipant) {
  for (int i = 0; i < 3; ++i) {
    const Participant participant({test::own_domain(), "lo"});
    EXPECT_GT(participant.handle(), 0);
  }
}

}  // namespace
}  // namespace waymark::dds
