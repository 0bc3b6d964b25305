// SPDX-License-Identifier: Apache-2.0
// `waymark map`: what a map's file holds, and the same map in another format.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/system/outputs.hpp"

namespace waymark::system_test {
namespace {

using testing::HasSubstr;

/// A folder with room.yaml and room.pgm: 5 × 4 cells of 0.1 m, three occupied, two unknown.
class MapCommand : public ::testing::Test {
 protected:
  MapCommand() {
    write_text(folder_ / "room.yaml", kLegend);
    write_text(folder_ / "room.pgm", "P5\n5 4\n255\n" + kPixels);
  }

  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  Outcome info(const std::string& name) const { return waymark({"map", "info", at(name)}); }
  Outcome convert(const std::string& in, const std::string& out, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"map", "convert", at(in), at(out)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return waymark(arguments);
  }

  const std::string kLegend =
      "image: room.pgm\nmode: trinary\nresolution: 0.1\norigin: [-0.2, 0.3, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
      "free_thresh: 0.196\n";
  const std::string kPixels = std::string("\xfe\xfe\xfe\xfe\x00", 5) + std::string("\xfe\xcd\xcd\xfe\x00", 5) +
                              std::string("\xfe\xfe\xfe\xfe\x00", 5) + std::string(5, '\xfe');
  TemporaryFolder folder_;
};

/// Passes if the command said nothing but `lines` among others, on standard output.
testing::AssertionResult shows(const Outcome& outcome, const std::vector<std::string>& lines) {
  if (outcome.exit_code != 0) return testing::AssertionFailure() << outcome.exit_code << ": " << outcome.err;
  if (!outcome.err.empty()) return testing::AssertionFailure() << "on stderr: " << outcome.err;
  for (const std::string& line : lines) {
    if (("\n" + outcome.out).find("\n" + line + "\n") == std::string::npos)
      return testing::AssertionFailure() << "no line \"" << line << "\" in\n" << outcome.out;
  }
  return testing::AssertionSuccess();
}

TEST_F(MapCommand, InfoTellsWhatAGridHolds) {
  EXPECT_TRUE(shows(info("room.yaml"), {"resolution  0.1 m", "size        0.500 x 0.400 m, 5 x 4 cells",
                                        "origin      x -0.200 y 0.300 m, yaw 0.0000 rad, the lower left corner",
                                        "occupied    3 cells", "free        15 cells", "unknown     2 cells"}));
}

TEST_F(MapCommand, AGridBecomesAnOctreeAndComesBack) {
  EXPECT_TRUE(shows(convert("room.yaml", "room.bt"), {}));
  const std::vector<std::string> figures{"resolution  0.1 m",
                                         "size        0.500 x 0.400 x 0.100 m, 5 x 4 x 1 voxels",
                                         "origin      x -0.200 y 0.300 z 0.000 m, the lower corner of what is known",
                                         "occupied    3 voxels",
                                         "free        15 voxels",
                                         "unknown     2 voxels within that size"};
  EXPECT_TRUE(shows(info("room.bt"), figures));
  EXPECT_TRUE(shows(convert("room.bt", "room.ot"), {}));
  EXPECT_TRUE(shows(info("room.ot"), figures));
  EXPECT_TRUE(shows(convert("room.ot", "again.bt"), {}));
  EXPECT_EQ(read_text(folder_ / "again.bt"), read_text(folder_ / "room.bt"));
  EXPECT_TRUE(shows(convert("again.bt", "a gain.yaml", {"--slice-m", "-0.1,0.1"}), {}));
  EXPECT_EQ(read_text(folder_ / "a gain.pgm"), read_text(folder_ / "room.pgm"));
  EXPECT_THAT(read_text(folder_ / "a gain.yaml"), HasSubstr("image: 'a gain.pgm'\n"));
  EXPECT_TRUE(shows(info("a gain.yaml"), {"occupied    3 cells"}));
  EXPECT_TRUE(has_no_partial_file(folder_.path()));
}

TEST_F(MapCommand, AnOctreeOfOctoMapItselfIsRead) {
  if (data_folder().empty()) GTEST_SKIP() << "WAYMARK_DATA is not set";
  const std::string corridor = data_folder() + "/octomap_samples/geb079.bt";
  if (!std::filesystem::exists(corridor)) GTEST_SKIP() << corridor << " is not there";
  EXPECT_TRUE(shows(waymark({"map", "info", corridor}), {"resolution  0.08 m"}));
  EXPECT_TRUE(shows(waymark({"map", "convert", corridor, at("corridor.ot")}), {}));
  EXPECT_TRUE(shows(convert("corridor.ot", "corridor.bt"), {}));
  const auto nodes = [](const std::string& file) {  // behind comments that may differ
    const std::string text = read_text(file);
    return text.substr(text.find("\nid OcTree\n"));
  };
  EXPECT_EQ(nodes(at("corridor.bt")), nodes(corridor));
}

TEST_F(MapCommand, VoxelsAreScoredAgainstSurfaces) {
  ASSERT_EQ(convert("room.yaml", "room.bt").exit_code, 0);
  // The occupied column of cells is at x 0.2 to 0.3, y 0.4 to 0.7; a wall through its middle, of the same length.
  write_text(folder_ / "truth.csv", "kind,x_m,y_m,x2_m,y2_m,half_width_m,height_m\nwall,0.25,0.4,0.25,0.7,0,0.1\n");
  const std::vector<std::string> arguments{"evaluate", "--voxels", at("room.bt"), "--surfaces", at("truth.csv")};
  const Outcome text = waymark(arguments);
  EXPECT_TRUE(shows(text, {"voxels"}));
  EXPECT_THAT(text.out, HasSubstr("100.00 %: 3 of 3 occupied voxels within 0.1 m of a true surface\n"));
  std::vector<std::string> with_json = arguments;
  with_json.insert(with_json.end(), {"--json", "--voxel-tolerance-m", "0.02"});
  const nlohmann::json voxels = nlohmann::json::parse(waymark(with_json).out).at("voxels");
  EXPECT_EQ(voxels.at("occupied"), 3);
  EXPECT_EQ(voxels.at("recall"), 1.0);
  EXPECT_EQ(voxels.at("tolerance_m"), 0.02);
  EXPECT_TRUE(
      reports_error(waymark({"evaluate", "--voxels", at("room.bt")}), 2, {"--voxels and --surfaces belong together"}));
  EXPECT_TRUE(reports_error(waymark({"evaluate", "--voxels", at("room.bt"), "--surfaces", at("room.yaml")}), 1,
                            {"room.yaml:1", "the first row must be"}));
}

TEST_F(MapCommand, InfoCountsLandmarks) {
  write_text(folder_ / "landmarks.csv", "name,x_m,y_m,radius_m\na,1,2,0.1\nb,4,2.5,\n");
  EXPECT_TRUE(shows(info("landmarks.csv"), {"landmarks   2", "size        3.000 x 0.500 m, between their middles",
                                            "origin      x 1.000 y 2.000 m, the lower left corner"}));
}

TEST_F(MapCommand, InfoCountsTheLandmarksOfAFeatureMap) {
  write_text(folder_ / "trunks.landmarks.yaml",
             "version: 1\nlandmarks:\n  - { east_m: 1, north_m: 2, radius_m: 0.1 }\n  - { east_m: 4, north_m: 2.5 }\n");
  EXPECT_TRUE(
      shows(info("trunks.landmarks.yaml"), {"landmarks   2", "size        3.000 x 0.500 m, between their middles"}));
  write_text(folder_ / "bad.landmarks.yaml", "version: 1\nlandmarks:\n  - { east_m: 1, north_m: 2, radus_m: 0.1 }\n");
  EXPECT_TRUE(
      reports_error(info("bad.landmarks.yaml"), 1, {"bad.landmarks.yaml:3", "radus_m", "did you mean \"radius_m\"?"}));
  write_text(folder_ / "newer.landmarks.yaml", "version: 2\nlandmarks: []\n");
  EXPECT_TRUE(reports_error(info("newer.landmarks.yaml"), 1, {"newer.landmarks.yaml:1", "2 is not 1"}));
}

TEST_F(MapCommand, AFileThatIsNoMapIsAnError) {
  EXPECT_TRUE(reports_error(info("gone.bt"), 1, {"gone.bt", "not found"}));
  EXPECT_TRUE(
      reports_error(info("room.png"), 1, {"room.png", "\".png\" is not an extension of a map", ".bt, .ot, .yaml"}));
  write_text(folder_ / "foreign.bt", "solid cube\n");
  EXPECT_TRUE(reports_error(info("foreign.bt"), 1, {"foreign.bt", "the first line must be"}));
  ASSERT_EQ(convert("room.yaml", "room.bt").exit_code, 0);
  const std::string whole = read_text(folder_ / "room.bt");
  write_text(folder_ / "cut.bt", whole.substr(0, whole.size() - 1));
  EXPECT_TRUE(reports_error(info("cut.bt"), 1, {"cut.bt", "truncated", "nodes are there"}));
  EXPECT_TRUE(reports_error(convert("cut.bt", "out.ot"), 1, {"cut.bt", "truncated"}));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.ot"));
}

TEST_F(MapCommand, APictureThatDisagreesWithItsYamlIsAnError) {
  write_text(folder_ / "room.pgm", "P5\n5 5\n255\n" + kPixels);
  EXPECT_TRUE(reports_error(info("room.yaml"), 1, {"room.pgm", "5 x 5 pixels are 25 bytes, but 20 are there"}));
  write_text(folder_ / "bad.yaml",
             "image: room.pgm\nresolution: 0\norigin: [0, 0, 0]\noccupied_thresh: 0.65\n"
             "free_thresh: 0.196\n");
  EXPECT_TRUE(reports_error(info("bad.yaml"), 1, {"bad.yaml:2", "resolution", "0"}));
  write_text(folder_ / "none.yaml",
             "image: gone.pgm\nresolution: 0.1\norigin: [0, 0, 0]\noccupied_thresh: 0.65\n"
             "free_thresh: 0.196\n");
  EXPECT_TRUE(reports_error(info("none.yaml"), 1, {"none.yaml:1:8: image", "gone.pgm", "not found"}));
  write_text(folder_ / "far.yaml",
             "image: room.pgm\nresolution: 0.1\norigin: [1e15, 0, 0]\noccupied_thresh: 0.65\nfree_thresh: 0.196\n");
  EXPECT_TRUE(reports_error(info("far.yaml"), 1, {"far.yaml:3", "origin", "x 1e+15 m"}));
}

TEST_F(MapCommand, AMapThatDoesNotFitIntoMemoryIsAnError) {
  write_text(folder_ / "room.pgm", "P5\n30000 30000\n255\n");
  std::filesystem::resize_file(folder_ / "room.pgm", 19 + 900'000'000);  // takes no space on the disk
  const auto limited = [] {
    const rlimit limit{600'000'000, 600'000'000};
    ::setrlimit(RLIMIT_AS, &limit);
  };
  const Outcome outcome = Command({"map", "info", at("room.yaml")}).in_child(limited).run();
  EXPECT_TRUE(reports_error(outcome, 1, {"room.yaml", "more memory than there is"}));
}

TEST_F(MapCommand, WhatCannotBeConvertedIsAnError) {
  ASSERT_EQ(convert("room.yaml", "room.bt").exit_code, 0);
  EXPECT_TRUE(reports_error(convert("room.bt", "out.yaml"), 2, {"--slice-m low,high"}));
  EXPECT_TRUE(reports_error(convert("room.bt", "out.ot", {"--slice-m", "0,1"}), 2, {"--slice-m is for an octree"}));
  EXPECT_TRUE(reports_error(convert("room.bt", "out.yaml", {"--slice-m", "3,4"}), 1, {"room.bt", "nothing is known"}));
  EXPECT_TRUE(reports_error(convert("room.bt", "out.yaml", {"--slice-m", "nan,4"}), 2,
                            {"--slice-m", "\"nan\" is not a finite"}));
  EXPECT_TRUE(reports_error(convert("room.yaml", "out.yaml"), 2, {"of one kind"}));
  EXPECT_TRUE(reports_error(convert("room.yaml", "out.csv"), 2, {"landmarks cannot be converted"}));
  EXPECT_TRUE(reports_error(convert("room.bt", "room.bt"), 2, {"overwrite itself"}));
  EXPECT_TRUE(reports_error(convert("room.yaml", "gone/room.bt"), 1, {"gone/room.bt"}));
  write_text(folder_ / "room.yaml",
             "image: room.pgm\nresolution: 0.1\norigin: [0, 0, 0.5]\noccupied_thresh: 0.65\nfree_thresh: 0.196\n");
  EXPECT_TRUE(reports_error(convert("room.yaml", "out.bt"), 1, {"room.yaml", "the yaw, is 0.5"}));
  EXPECT_EQ(waymark({"map"}).exit_code, 2);
  EXPECT_EQ(waymark({"map", "convert", at("room.bt")}).exit_code, 2);
  EXPECT_THAT(waymark({"map", "convert", "--help"}).out, HasSubstr("Example:\n  waymark map convert"));
}

}  // namespace
}  // namespace waymark::system_test
