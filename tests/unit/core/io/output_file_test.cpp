// SPDX-License-Identifier: Apache-2.0
#include "waymark/io/output_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>
#include <sstream>

#include "temporary_folder.hpp"
#include "waymark/base/error.hpp"

namespace waymark {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;
using testing::ThrowsMessage;

std::string content(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

/// No file may grow beyond `bytes` while this lives: a disk that is full.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) : old_handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &old_limit_);
    const rlimit limit{bytes, old_limit_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &old_limit_);
    std::signal(SIGXFSZ, old_handler_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  void (*old_handler_)(int);
  rlimit old_limit_{};
};

class OutputFileTest : public testing::Test {
 protected:
  std::filesystem::path file() const { return folder_ / "out.txt"; }
  std::filesystem::path partial() const { return folder_ / "out.txt.partial"; }

  test::TemporaryFolder folder_;
};

TEST_F(OutputFileTest, AppearsOnlyWithCommit) {
  OutputFile out(file());
  out.write("one\n");
  EXPECT_FALSE(std::filesystem::exists(file()));
  EXPECT_TRUE(std::filesystem::exists(partial()));
  out.write("two\n");
  out.commit();
  EXPECT_EQ(content(file()), "one\ntwo\n");
  EXPECT_FALSE(std::filesystem::exists(partial()));
}

TEST_F(OutputFileTest, LeavesNothingWithoutCommit) {
  {
    OutputFile out(file());
    out.write("one\n");
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

TEST_F(OutputFileTest, KeepsTheOldFileUntilCommit) {
  write_file(file(), "old");
  { OutputFile out(file()); }
  EXPECT_EQ(content(file()), "old");
}

TEST_F(OutputFileTest, WritesMoreThanTheBuffer) {
  std::string expected;
  OutputFile out(file());
  for (int i = 0; i < 50'000; ++i) {
    const std::string line = std::to_string(i) + '\n';
    expected += line;
    out.write(line);
  }
  out.commit();
  EXPECT_EQ(content(file()), expected);
}

TEST_F(OutputFileTest, MovingHandsTheFileOver) {
  OutputFile first(file());
  first.write("one\n");
  OutputFile second(std::move(first));
  second.write("two\n");
  second.commit();
  EXPECT_EQ(content(file()), "one\ntwo\n");
}

TEST_F(OutputFileTest, FullDiskKeepsTheCompleteLines) {
  OutputFile out(file());
  for (int i = 0; i < 1000; ++i) out.write("123456789\n");
  const FullDisk disk(4096);
  EXPECT_THAT([&] { out.commit(); },
              ThrowsMessage<Error>(AllOf(StartsWith(file().string() + ": writing: "), HasSubstr("large"))));
  EXPECT_EQ(std::filesystem::file_size(file()), 4090u);
  EXPECT_EQ(content(file()).back(), '\n');
  EXPECT_FALSE(std::filesystem::exists(partial()));
}

TEST_F(OutputFileTest, FullDiskWithNoCompleteLineLeavesTheOldFile) {
  write_file(file(), "old\n");
  OutputFile out(file());
  out.write(std::string(10'000, 'x'));
  const FullDisk disk(4096);
  EXPECT_THROW(out.commit(), Error);
  EXPECT_EQ(content(file()), "old\n");
  EXPECT_FALSE(std::filesystem::exists(partial()));
}

TEST_F(OutputFileTest, RefusesToWriteAfterAFailure) {
  OutputFile out(file());
  out.write(std::string(10'000, 'x'));
  const FullDisk disk(4096);
  EXPECT_THROW(out.commit(), Error);
  EXPECT_THROW(out.write("more"), Error);
  EXPECT_THROW(out.commit(), Error);
}

TEST_F(OutputFileTest, NamesFileAndReasonIfItCannotBeCreated) {
  const std::filesystem::path missing = folder_ / "missing" / "out.txt";
  EXPECT_THAT([&] { OutputFile out(missing); },
              ThrowsMessage<Error>(AllOf(HasSubstr(missing.string()), HasSubstr("No such file or directory"))));
}

TEST_F(OutputFileTest, RefusesAFolder) {
  EXPECT_THAT([&] { OutputFile out(folder_); }, ThrowsMessage<Error>(HasSubstr("Is a directory")));
}

TEST_F(OutputFileTest, WriteFileWritesTheWholeFile) {
  write_file(file(), std::string("a\0b", 3));
  EXPECT_EQ(content(file()), std::string("a\0b", 3));
}

TEST_F(OutputFileTest, WriteFileKeepsTheOldFileIfTheDiskIsFull) {
  write_file(file(), "old\n");
  const FullDisk disk(4096);
  EXPECT_THROW(write_file(file(), std::string(5000, '\n')), Error);
  EXPECT_EQ(content(file()), "old\n");
  EXPECT_FALSE(std::filesystem::exists(partial()));
}

TEST(OutputFile, ALinkInPlaceOfThePartialFileIsNotFollowed) {
  const test::TemporaryFolder folder;
  write_file(folder / "precious", "mine\n");
  std::filesystem::create_symlink(folder / "precious", folder / "a.txt.partial");
  {
    OutputFile file(folder / "a.txt");
    file.write("ours\n");
    file.commit();
  }
  std::filesystem::create_symlink(folder / "precious", folder / "b.txt.partial");
  write_file(folder / "b.txt", "ours\n");
  EXPECT_EQ(content(folder / "precious"), "mine\n");
  EXPECT_EQ(content(folder / "a.txt"), "ours\n");
  EXPECT_FALSE(std::filesystem::is_symlink(folder / "b.txt"));
}

TEST(OutputFile, DoesNotGiveItsNameToTheFileOfAnotherProgram) {
  const test::TemporaryFolder folder;
  OutputFile first(folder / "a.txt");
  first.write("first\n");
  OutputFile second(folder / "a.txt");
  second.write("second\n");
  EXPECT_THROW(first.commit(), Error);
  second.commit();
  EXPECT_EQ(content(folder / "a.txt"), "second\n");
}

}  // namespace
}  // namespace waymark
