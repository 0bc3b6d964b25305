// SPDX-License-Identifier: Apache-2.0
#include "run_folder.hpp"

#include <gmock/gmock.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>

#include "temporary_folder.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark::host {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class RunFolderTest : public testing::Test {
 protected:
  /// A run that writes these files, as sinks do.
  RunFolder::Replaced run(const std::vector<std::string>& names, bool complete = true) {
    RunFolder run(out_.path());
    write(names);
    return run.finish(complete);
  }
  void write(const std::vector<std::string>& names) {
    for (const std::string& name : names) {
      std::filesystem::create_directories((out_ / name).parent_path());
      write_file(out_ / name, "of a run\n");
    }
  }
  void by_hand(const std::string& name, const std::string& text) { std::ofstream(out_ / name) << text; }
  bool has(const std::string& name) const { return std::filesystem::exists(out_ / name); }

  test::TemporaryFolder out_;
};

TEST_F(RunFolderTest, RemovesWhatAnEarlierRunWroteAndThisOneDidNot) {
  EXPECT_FALSE(run({"trajectory.txt", "map.png"}).any);
  const RunFolder::Replaced replaced = run({"trajectory.txt"});
  EXPECT_TRUE(replaced.any);
  EXPECT_THAT(replaced.removed, ElementsAre("map.png"));
  EXPECT_FALSE(has("map.png"));
  EXPECT_TRUE(has("trajectory.txt"));
}

TEST_F(RunFolderTest, KeepsWhatNoRunWrote) {
  by_hand("notes.txt", "mine\n");
  RunFolder first(out_.path());
  write({"map.png"});
  by_hand("more_notes.txt", "written while it ran\n");
  first.finish(true);
  run({"trajectory.txt"});
  EXPECT_FALSE(has("map.png"));
  EXPECT_TRUE(has("notes.txt"));
  EXPECT_TRUE(has("more_notes.txt"));
}

TEST_F(RunFolderTest, KeepsAFileThatSomebodyHasChanged) {
  run({"longer.txt", "same_size.txt"});
  by_hand("longer.txt", "of a run, and what I think of it\n");
  by_hand("same_size.txt", "of a run\n");
  const auto later = std::filesystem::last_write_time(out_ / ".waymark_files") + std::chrono::seconds(1);
  std::filesystem::last_write_time(out_ / "same_size.txt", later);
  const RunFolder::Replaced replaced = run({"trajectory.txt"});
  EXPECT_THAT(replaced.removed, IsEmpty());
  EXPECT_THAT(replaced.changed, ElementsAre("longer.txt", "same_size.txt"));
  EXPECT_TRUE(has("longer.txt"));
  EXPECT_TRUE(has("same_size.txt"));
}

TEST_F(RunFolderTest, RemovesNothingIfTheNewResultsAreNotCompleteButTheNextRunDoes) {
  run({"trajectory.txt", "map.png"});
  EXPECT_THAT(run({"trajectory.txt"}, false).left, ElementsAre("map.png"));
  EXPECT_TRUE(has("map.png"));
  EXPECT_THAT(run({"trajectory.txt"}).removed, ElementsAre("map.png"));
  EXPECT_FALSE(has("map.png"));
}

TEST_F(RunFolderTest, TakesOverTheFilesOfARunThatWasKilled) {
  {
    RunFolder killed(out_.path());
    write({"reference.txt"});
  }
  EXPECT_THAT(run({"trajectory.txt"}).removed, ElementsAre("reference.txt"));
}

TEST_F(RunFolderTest, RemovesAFolderThatHeldNothingElse) {
  run({"log/wheels.csv", "pictures/1.png"});
  by_hand("pictures/mine.png", "mine");
  run({"trajectory.txt"});
  EXPECT_FALSE(has("log"));
  EXPECT_FALSE(has("pictures/1.png"));
  EXPECT_TRUE(has("pictures/mine.png"));
}

TEST_F(RunFolderTest, AListThatNamesFilesOutsideRemovesNone) {
  test::TemporaryFolder other;
  std::ofstream(other / "precious.txt") << "mine\n";
  const std::string outside = std::filesystem::relative(other / "precious.txt", out_.path()).string();
  by_hand(".waymark_files", "5 " + outside + "\n5 " + (other / "precious.txt").string() + "\n");
  EXPECT_THAT(run({"trajectory.txt"}).removed, IsEmpty());
  EXPECT_TRUE(std::filesystem::exists(other / "precious.txt"));
}

TEST_F(RunFolderTest, WhatBelongsToNobodyStays) {
  RunFolder first(out_.path());
  write_file(out_ / "half.ckpt", "a later run begins here", Belongs::to_nobody);
  first.finish(true);
  run({"trajectory.txt"});
  EXPECT_TRUE(has("half.ckpt"));
}

}  // namespace
}  // namespace waymark::host
