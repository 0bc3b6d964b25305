// SPDX-License-Identifier: Apache-2.0
// needs plugins: csv, diagnostics, dgps, feature_map, landmarks, odometry, plot, tum
// Whatever ends a run, its results are kept; no run writes over another's, or outside of its folder.
#include <gmock/gmock.h>
#include <sys/file.h>

#include <algorithm>
#include <boost/crc.hpp>
#include <cstring>
#include <map>

#include "tests/system/small_robot.hpp"

namespace waymark::system_test {
namespace {

using std::string_literals::operator""s;
using testing::HasSubstr;
using testing::Not;

constexpr std::size_t kRows = 1000;  // of the trajectory, at least

TEST(ResultsKept, WithoutStandardStreamsNothingGetsIntoAResult) {
  SmallRobot robot;
  robot.write();
  const Outcome outcome = robot.command()
                              .in_child([] {
                                ::close(STDIN_FILENO);
                                ::close(STDOUT_FILENO);
                                ::close(STDERR_FILENO);
                              })
                              .run();
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_TRUE(robot.has_results(kRows));
  EXPECT_THAT(read_text(robot.out() / "trajectory.txt"), Not(HasSubstr("waymark")));
  EXPECT_THAT(read_text(robot.out() / "trajectory.txt"), Not(HasSubstr("%")));
}

TEST(ResultsKept, WhereTheCheckpointCannotBeWritten) {
  SmallRobot robot;
  const Outcome outcome = robot.run({"--save", robot.file("no/such/folder/half.ckpt").string()});
  EXPECT_TRUE(reports_error(outcome, 3, {"the checkpoint is not written", "half.ckpt"}));
  EXPECT_TRUE(robot.has_results(kRows));
}

TEST(ResultsKept, ASecondRunInTheSameFolderIsRefused) {
  SmallRobot robot;
  ASSERT_EQ(robot.run().exit_code, 0);
  const std::string before = read_text(robot.out() / "config.yaml");
  const int folder = ::open(robot.out().c_str(), O_RDONLY | O_DIRECTORY);
  ASSERT_EQ(::flock(folder, LOCK_EX | LOCK_NB), 0);
  EXPECT_TRUE(
      reports_error(robot.run({"--seed", "5"}), 1, {robot.out().string(), "another run writes to this folder"}));
  ::close(folder);
  EXPECT_EQ(read_text(robot.out() / "config.yaml"), before);
  EXPECT_EQ(robot.run({"--seed", "5"}).exit_code, 0);
}

TEST(ResultsKept, ARunThatFailsLeavesTheConfigurationOfTheOlderResults) {
  SmallRobot robot;
  ASSERT_EQ(robot.run().exit_code, 0);
  const std::string before = read_text(robot.out() / "config.yaml");
  EXPECT_EQ(robot.run({"--seed", "7", "--resume", robot.file("no.ckpt").string()}).exit_code, 1);
  EXPECT_EQ(read_text(robot.out() / "config.yaml"), before);
  EXPECT_EQ(robot.run({"--seed", "7"}).exit_code, 0);
  EXPECT_THAT(read_text(robot.out() / "config.yaml"), HasSubstr("seed: 7"));
}

TEST(ResultsKept, TwoOutputsOfOneNameAreRefused) {
  SmallRobot robot;
  const Outcome outcome = robot.run({"--set", "sinks.landmarks.file=trajectory.txt"});
  EXPECT_TRUE(reports_error(outcome, 1, {"sinks.landmarks.file", "\"trajectory.txt\"", "sinks.tum.trajectory"}));
  EXPECT_TRUE(reports_error(robot.run({"--set", "sinks.tum.trajectory=config.yaml"}), 1,
                            {"sinks.tum.trajectory", "\"config.yaml\" is written by the run itself"}));
  EXPECT_FALSE(std::filesystem::exists(robot.out()));
}

TEST(ResultsKept, AnOutputOutsideOfTheFolderIsRefused) {
  SmallRobot robot;
  for (const std::string& name : {robot.file("elsewhere.csv").string(), std::string("../elsewhere.csv")}) {
    EXPECT_TRUE(reports_error(robot.run({"--set", "sinks.landmarks.file=" + name}), 1,
                              {"sinks.landmarks.file", name, "--allow-outside"}));
  }
  EXPECT_FALSE(std::filesystem::exists(robot.file("elsewhere.csv")));
  EXPECT_EQ(robot.run({"--set", "sinks.landmarks.file=../elsewhere.csv", "--allow-outside"}).exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(robot.file("elsewhere.csv")));
}

TEST(ResultsKept, ALinkInPlaceOfAPartialFileIsNotFollowed) {
  SmallRobot robot;
  robot.write();
  std::filesystem::create_directories(robot.out());
  write_text(robot.file("precious"), "mine\n");
  std::filesystem::create_symlink(robot.file("precious"), robot.out() / "trajectory.txt.partial");
  EXPECT_EQ(robot.run().exit_code, 0);
  EXPECT_EQ(read_text(robot.file("precious")), "mine\n");
  EXPECT_TRUE(robot.has_results(kRows));
}

class Checkpoint : public testing::Test {
 protected:
  void SetUp() override { ASSERT_EQ(robot_.run({"--until", "15", "--save", file()}).exit_code, 0); }

  std::string file() const { return robot_.file("half.ckpt").string(); }
  Outcome resume(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"--resume", file()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return robot_.run(arguments);
  }

  SmallRobot robot_;
};

TEST_F(Checkpoint, OfTheSameRunIsResumedWithOtherSinksAndThreads) {
  EXPECT_EQ(resume().exit_code, 0);
  EXPECT_EQ(resume({"--threads", "2", "--set", "sinks.landmarks.confirmed_only=false"}).exit_code, 0);
}

TEST_F(Checkpoint, OfAnotherConfigurationIsRefused) {
  EXPECT_TRUE(reports_error(resume({"--seed", "9"}), 1, {file(), "another configuration", "filter.threads"}));
  EXPECT_TRUE(reports_error(resume({"--set", "filter.resample_threshold=0.7"}), 1, {file(), "another configuration"}));
}

TEST_F(Checkpoint, OfAnotherLogIsRefused) {
  robot_.twist[5] = "0.081,0.5,0.0";
  EXPECT_TRUE(reports_error(resume(), 1, {file(), "another log"}));
}

TEST_F(Checkpoint, ThatIsDamagedIsRefused) {
  const std::string whole = read_text(file());
  for (const std::size_t at : {std::size_t{3}, std::size_t{30}, whole.size() / 2, whole.size() - 1}) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    write_text(file(), damaged);
    EXPECT_TRUE(reports_error(resume(), 1, {file(), "checkpoint"})) << "byte " << at;
  }
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{10}, std::size_t{40}, whole.size() / 2, whole.size() - 1}) {
    write_text(file(), whole.substr(0, size));
    EXPECT_TRUE(reports_error(resume(), 1, {file(), "checkpoint"})) << size << " bytes";
  }
}

/// The rows of a text below its header.
std::string rows_of(const std::filesystem::path& file) {
  const std::string text = read_text(file);
  return text.substr(text.find('\n') + 1);
}

TEST_F(Checkpoint, ARunThatIsResumedWritesTheRestOfTheRows) {
  for (const std::string maps : {"", "maps=[]"}) {
    const std::vector<std::string> more = maps.empty() ? std::vector<std::string>{} : std::vector{"--set"s, maps};
    const auto with = [&](std::vector<std::string> arguments) {
      arguments.insert(arguments.end(), more.begin(), more.end());
      return arguments;
    };
    ASSERT_EQ(robot_.run(with({})).exit_code, 0);
    std::map<std::string, std::string> whole;
    std::map<std::string, std::string> begun;
    for (const std::string name : {"trajectory.txt", "covariance.csv"}) whole[name] = rows_of(robot_.out() / name);
    ASSERT_EQ(robot_.run(with({"--until", "15", "--save", file()})).exit_code, 0);
    for (const std::string name : {"trajectory.txt", "covariance.csv"}) begun[name] = rows_of(robot_.out() / name);
    ASSERT_EQ(resume(more).exit_code, 0);
    for (const std::string name : {"trajectory.txt", "covariance.csv"})
      EXPECT_EQ(begun[name] + rows_of(robot_.out() / name), whole[name]) << name << " " << maps;
  }
}

TEST_F(Checkpoint, OfEqualRunsHasEqualBytes) {
  const std::string first = read_text(file());
  ASSERT_EQ(robot_.run({"--until", "15", "--save", file(), "--threads", "2"}).exit_code, 0);
  EXPECT_EQ(read_text(file()), first);
}

/// The checksum of a checkpoint, as it is written.
void renew_checksum(std::string& bytes) {
  constexpr std::size_t kHeader = 21;  // behind "waymark checkpoint 1\n": identities and size, 24 bytes, and checksum
  boost::crc_32_type crc;
  crc.process_bytes(bytes.data() + kHeader, 24);
  crc.process_bytes(bytes.data() + kHeader + 32, bytes.size() - kHeader - 32);
  const std::uint64_t sum = crc.checksum();
  std::memcpy(bytes.data() + kHeader + 24, &sum, sizeof sum);
}

TEST_F(Checkpoint, ThatIsDamagedUnderAValidChecksumIsRefusedWithItsName) {
  const std::string whole = read_text(file());
  std::string same = whole;
  renew_checksum(same);
  ASSERT_EQ(same, whole);
  constexpr std::size_t kName = 4;    // behind "SECT": a damaged one fits no section
  constexpr std::size_t kValue = 30;  // a number, which may happen to be allowed
  int refused = 0;
  for (const std::size_t offset : {kName, kValue}) {
    for (std::size_t section = whole.find("SECT"); section != std::string::npos;
         section = whole.find("SECT", section + whole.size() / 30)) {
      std::string damaged = whole;
      const std::size_t begin = section + offset;
      for (std::size_t at = begin; at < std::min(begin + 4, whole.size()); ++at) damaged[at] = '\xff';
      renew_checksum(damaged);
      write_text(file(), damaged);
      const Outcome outcome = resume();
      if (offset == kValue && outcome.exit_code == 0) continue;
      EXPECT_TRUE(reports_error(outcome, 1, {file()})) << "section at byte " << section << ", offset " << offset;
      ++refused;
    }
  }
  EXPECT_GT(refused, 3);
}

TEST(Threads, MoreThanTheSystemStartsAreAnError) {
  SmallRobot robot;
  robot.write();
  const Outcome outcome = robot.command({"--threads", "256"})
                              .in_child([] {
                                const rlimit memory{rlim_t{1} << 30, rlim_t{1} << 30};
                                ::setrlimit(RLIMIT_AS, &memory);
                              })
                              .run();
  EXPECT_TRUE(reports_error(outcome, 1, {"of 256 threads can be started"}));
}

}  // namespace
}  // namespace waymark::system_test
