// SPDX-License-Identifier: Apache-2.0
// Clouds in PCD and tables, and the file that is made of them.
#include "apps/waymark/import/clouds.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <string>

#include "apps/waymark/import/lzf.hpp"
#include "apps/waymark/import/point_file.hpp"
#include "plugins/shared/cloud_file/cloud_reader.hpp"
#include "temporary_folder.hpp"
#include "waymark/base/error.hpp"

namespace waymark::imports {
namespace {

using ::testing::ElementsAre;
using ::testing::FloatEq;
using ::testing::FloatNear;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

template <class T>
std::string raw_bytes(const T& value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

std::string error_in(const std::function<void()>& act) {
  try {
    act();
  } catch (const DataError& error) {
    return error.what();
  }
  ADD_FAILURE() << "no error";
  return {};
}

/// A head of two points with a time of whole nanoseconds between the coordinates.
std::string pcd_head(const std::string& data, const std::string& points = "2") {
  return "# .PCD v0.7\nVERSION 0.7\nFIELDS x t y _ z intensity\nSIZE 4 4 4 1 8 2\nTYPE F U F U F U\nCOUNT 1 1 1 3 1 1\n"
         "WIDTH " +
         points + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + points + "\nDATA " + data + "\n";
}

std::string pcd_point(float x, std::uint32_t t, float y, double z, std::uint16_t intensity) {
  return raw_bytes(x) + raw_bytes(t) + raw_bytes(y) + "abc" + raw_bytes(z) + raw_bytes(intensity);
}

const std::string kTwoPoints = pcd_point(1.0f, 0, 2.0f, 3.0, 7) + pcd_point(4.0f, 50'000'000, 5.0f, 6.0, 9);

void expect_two_points(const PointFile& file) {
  EXPECT_THAT(file.cloud.points_m, ElementsAre(Eigen::Vector3f(1, 2, 3), Eigen::Vector3f(4, 5, 6)));
  EXPECT_THAT(file.cloud.intensities, ElementsAre(7.0f, 9.0f));
  EXPECT_THAT(file.cloud.offsets_s, ElementsAre(0.0f, FloatEq(0.05f)));
  EXPECT_THAT(file.notes, IsEmpty());
}

TEST(Pcd, AllThreeFormsGiveTheSame) {
  expect_two_points(read_pcd(pcd_head("ascii") + "1 0 2 0 0 0 3 7\r\n\n 4 50000000 5 0 0 0 6 9", "a.pcd", {}));
  expect_two_points(read_pcd(pcd_head("binary") + kTwoPoints, "a.pcd", {}));
  // Compressed: field after field, here as literals of at most 32 bytes each.
  const std::string fields = raw_bytes(1.0f) + raw_bytes(4.0f) + raw_bytes(0U) + raw_bytes(50'000'000U) +
                             raw_bytes(2.0f) + raw_bytes(5.0f) + "abcabc" + raw_bytes(3.0) + raw_bytes(6.0) +
                             raw_bytes(std::uint16_t{7}) + raw_bytes(std::uint16_t{9});
  std::string packed;
  for (std::size_t at = 0; at < fields.size(); at += 32) {
    const std::string part = fields.substr(at, 32);
    packed += static_cast<char>(part.size() - 1) + part;
  }
  const std::string sizes =
      raw_bytes(static_cast<std::uint32_t>(packed.size())) + raw_bytes(static_cast<std::uint32_t>(fields.size()));
  expect_two_points(read_pcd(pcd_head("binary_compressed") + sizes + packed, "a.pcd", {}));
}

TEST(Pcd, LzfRepeatsWhatWasUnpackedBefore) {
  // "ab", then 7 bytes from 2 back; a long one of 9 + 3 bytes from 1 back.
  EXPECT_EQ(unpack_lzf(std::string_view("\x01"
                                        "ab\xa0\x01",
                                        5),
                       9),
            "ababababa");
  EXPECT_EQ(unpack_lzf(std::string_view("\x00"
                                        "a\xe0\x03\x00",
                                        5),
                       13),
            std::string(13, 'a'));
  EXPECT_FALSE(unpack_lzf(std::string_view("\x01"
                                           "ab\xa0\x01",
                                           5),
                          8))
      << "more than was stated";
  EXPECT_FALSE(unpack_lzf(std::string_view("\x01"
                                           "ab\xa0\x01",
                                           5),
                          10))
      << "less";
  EXPECT_FALSE(unpack_lzf(std::string_view("\x01"
                                           "ab\xa0\x02",
                                           5),
                          9))
      << "before the beginning";
  EXPECT_FALSE(unpack_lzf(std::string_view("\x05"
                                           "ab",
                                           3),
                          6))
      << "cut";
  EXPECT_FALSE(unpack_lzf(std::string_view("\x00"
                                           "a\xe0",
                                           3),
                          13))
      << "cut";
}

TEST(Pcd, SizesThatItCannotHoldAreNotBelieved) {
  const auto error = [](const std::string& content) { return error_in([&] { read_pcd(content, "a.pcd", {}); }); };
  EXPECT_EQ(error(pcd_head("binary", "3") + kTwoPoints),
            "a.pcd: states 3 points of 25 bytes, and 50 bytes follow the head");
  EXPECT_THAT(error(pcd_head("binary", "4294967295")), HasSubstr("states 4294967295 points; at most 16777216"));
  EXPECT_THAT(error(pcd_head("binary", "4294967296")), HasSubstr("a.pcd:7: \"4294967296\" is no whole number up to"));
  EXPECT_THAT(error(pcd_head("binary", "-1")), HasSubstr("\"-1\" is no whole number"));
  EXPECT_THAT(error(pcd_head("ascii", "3") + "1 0 2 0 0 0 3 7\n"), HasSubstr("a.pcd: ends after 1 of its 3 points"));
  EXPECT_THAT(error(pcd_head("ascii", "0") + "1 0 2 0 0 0 3 7\n"),
              HasSubstr("a.pcd:12: is one more than the 0 points"));
  EXPECT_THAT(error(pcd_head("ascii", "1") + "1 0 2 0 0 0 three 7\n"),
              HasSubstr("\"three\" is no number of the field z"));
  EXPECT_THAT(error(pcd_head("ascii", "1") + "1 0 2\n"), HasSubstr("\"\" is no number of the field _"));
  EXPECT_THAT(error(pcd_head("binary_compressed") + "123"), HasSubstr("ends within the sizes"));
  EXPECT_THAT(error(pcd_head("binary_compressed") + raw_bytes(0xffff'ffffU) + raw_bytes(50U)),
              HasSubstr("states 4294967295 bytes of compressed points, and 0 follow"));
  EXPECT_THAT(error(pcd_head("binary_compressed") + raw_bytes(0U) + raw_bytes(0xffff'ffffU)),
              HasSubstr("its points unpack to 4294967295 bytes; 2 points have 50"));
  EXPECT_THAT(error(pcd_head("binary_compressed") + raw_bytes(2U) + raw_bytes(50U) + "\x05x"),
              HasSubstr("its compressed points are damaged"));
}

TEST(Pcd, AHeadThatIsNoneIsRefusedAtItsLine) {
  const auto error = [](const std::string& content) { return error_in([&] { read_pcd(content, "a.pcd", {}); }); };
  EXPECT_THAT(error("ply\nformat ascii 1.0\n"), HasSubstr("a.pcd:1: \"ply\" is no word of the head of a PCD"));
  EXPECT_THAT(error("VERSION 0.7\n"), HasSubstr("is no PCD: there is no line DATA"));
  EXPECT_THAT(error(pcd_head("text")), HasSubstr("a.pcd:11: DATA \"text\" is not one of: ascii, binary"));
  EXPECT_THAT(error("FIELDS x y\nSIZE 4\n"), HasSubstr("a.pcd:2: SIZE has 1 words; there are 2 fields"));
  EXPECT_THAT(error("FIELDS x y\nSIZE 4 4\nTYPE F F\nWIDTH 0\nHEIGHT 1\nDATA ascii\n"), HasSubstr("no x, y and z"));
  EXPECT_THAT(error("FIELDS x y z\nSIZE 4 4 2\nTYPE F F F\nPOINTS 0\nDATA ascii\n"),
              HasSubstr("the field z of TYPE F and SIZE 2 is no number"));
  EXPECT_THAT(error("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nHEIGHT 2\nPOINTS 3\nDATA ascii\n"),
              HasSubstr("2 x 2 points are not the 3 of POINTS"));
  EXPECT_THAT(error("FIELDS x y z\nDATA ascii\n"), HasSubstr("neither POINTS nor WIDTH and HEIGHT are given"));
}

TEST(Pcd, PointsThatAreNotFiniteAreLeftOut) {
  const PointFile file = read_pcd(
      "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 1 0 0 1 0 0 0\nDATA ascii\nnan nan nan\n1 2 "
      "3\n",
      "a.pcd", {});
  EXPECT_THAT(file.cloud.points_m, ElementsAre(Eigen::Vector3f(1, 2, 3)));
  EXPECT_EQ(file.not_finite, 1U);
  EXPECT_THAT(file.notes, ElementsAre(HasSubstr("its VIEWPOINT is not the origin")));
}

TEST(PointTable, ReadsColumnsByNameOrTheFirstThree) {
  const Time stamp = parse_time("1700000000");
  PointFile file = read_point_table("# made by me\nT;Intensity;\"Z\";y_m;X\n1700000000.25;5;3;2;1\r\n", "a.csv", stamp);
  EXPECT_THAT(file.cloud.points_m, ElementsAre(Eigen::Vector3f(1, 2, 3)));
  EXPECT_THAT(file.cloud.intensities, ElementsAre(5.0f));
  EXPECT_THAT(file.cloud.offsets_s, ElementsAre(FloatNear(0.25f, 1e-6f)));
  file = read_point_table("1 2 3 99\n  +4\t5e-1 6\n\n", "a.txt", stamp);
  EXPECT_THAT(file.cloud.points_m, ElementsAre(Eigen::Vector3f(1, 2, 3), Eigen::Vector3f(4, 0.5f, 6)));
  EXPECT_THAT(file.cloud.intensities, IsEmpty());
  file = read_point_table("//X,Y,Z,t_ns\n1,2,3,5000000\nnan,2,3,0\n", "a.csv", stamp);
  EXPECT_THAT(file.cloud.offsets_s, ElementsAre(FloatEq(0.005f)));
  EXPECT_EQ(file.not_finite, 1U);
}

TEST(PointTable, ALineThatIsNoneIsRefused) {
  const auto error = [](const std::string& content) {
    return error_in([&] { read_point_table(content, "a.csv", {}); });
  };
  EXPECT_EQ(error("x,y,z\n1,2,3\n1,2\n"), "a.csv:3: 2 columns; at least 3 are expected");
  EXPECT_EQ(error("1,2,three\n"), "a.csv:1: \"three\" is no number");
  EXPECT_EQ(error("x,y,h\n1,2,3\n"), "a.csv:1: the header has no columns x, y and z");
  EXPECT_EQ(error("# nothing\n\n"), "a.csv: holds no line with a point");
}

/// A folder with two clouds of one and two points.
class ImportOfClouds : public ::testing::Test {
 protected:
  ImportOfClouds() {
    write("1630577758.569490.csv", "x,y,z\n1,2,3\n");
    write("1630577758.669490001.csv", "x,y,z\n4,5,6\n7,8,9\n");
    settings_.out = folder_ / "clouds.bin.gz";
    settings_.files = {folder_ / "1630577758.569490.csv", folder_ / "1630577758.669490001.csv"};
  }
  void write(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
  }
  std::vector<std::string> stamps() const {
    cloud_file::CloudReader reader(settings_.out);
    std::vector<std::string> all;
    while (const auto head = reader.next()) all.push_back(format_time(head->stamp.value()));
    return all;
  }
  std::string error() const {
    return error_in([&] { import_clouds(settings_); });
  }

  test::TemporaryFolder folder_;
  CloudImport settings_;
};

TEST_F(ImportOfClouds, TimesAreThoseOfTheNamesOfATableOrEvenlySpaced) {
  settings_.times_in_names = true;
  const ImportedClouds imported = import_clouds(settings_);
  EXPECT_EQ(imported.clouds, 2U);
  EXPECT_EQ(imported.points, 3U);
  EXPECT_THAT(stamps(), ElementsAre("1630577758.569490000", "1630577758.669490001"));

  settings_.times_in_names = false;
  import_clouds(settings_);
  EXPECT_THAT(stamps(), ElementsAre("0.000000000", "0.100000000"));
  settings_.start = parse_time("7.5");
  settings_.period = std::chrono::milliseconds(500);
  import_clouds(settings_);
  EXPECT_THAT(stamps(), ElementsAre("7.500000000", "8.000000000"));

  settings_.times = folder_ / "times.csv";
  write("times.csv", "t_s,number\n1.25,0\n1.5,1\n");
  import_clouds(settings_);
  EXPECT_THAT(stamps(), ElementsAre("1.250000000", "1.500000000"));

  cloud_file::CloudReader reader(settings_.out);
  PointCloud cloud;
  reader.next();
  reader.next();
  reader.read({}, cloud);
  EXPECT_THAT(cloud.points_m, ElementsAre(Eigen::Vector3f(4, 5, 6), Eigen::Vector3f(7, 8, 9)));
}

TEST_F(ImportOfClouds, WholeNanosecondsMayBeNames) {
  settings_.times_in_names = true;
  settings_.files = {folder_ / "1630577758569490001.csv"};
  write("1630577758569490001.csv", "1 2 3\n");
  import_clouds(settings_);
  EXPECT_THAT(stamps(), ElementsAre("1630577758.569490001"));
}

TEST_F(ImportOfClouds, WhatDoesNotFitIsRefusedAndNothingIsWritten) {
  settings_.files = {settings_.files[1], settings_.files[0]};
  settings_.times_in_names = true;
  EXPECT_THAT(error(),
              HasSubstr("1630577758.569490.csv: its time, 1630577758.569490000, is not later than that of the"));
  settings_.files = {folder_ / "scan.csv"};
  write("scan.csv", "1 2 3\n");
  EXPECT_THAT(error(), HasSubstr("scan.csv: its name is no time"));
  settings_.times = folder_ / "times.csv";
  write("times.csv", "1\n2\n");
  EXPECT_THAT(error(), HasSubstr("times.csv: has 2 times; there are 1 files"));
  write("times.csv", "1\nlater\n");
  EXPECT_THAT(error(), HasSubstr("times.csv:2: "));
  settings_.times.clear();
  settings_.times_in_names = false;
  settings_.files = {folder_ / "scan.csv", folder_ / "with.csv"};
  write("with.csv", "x,y,z,intensity\n1,2,3,4\n");
  EXPECT_THAT(error(), HasSubstr("with.csv: has intensities, unlike"));
  write("with.csv", "x,y,z,t\n1,2,3,4\n");
  EXPECT_THAT(error(), HasSubstr("with.csv: has times of points, unlike"));
  EXPECT_FALSE(std::filesystem::exists(settings_.out));
  settings_.files = {settings_.out};
  write("clouds.bin.gz", "1 2 3\n");
  EXPECT_THAT(error(), HasSubstr("is one of the files that are read"));
}

}  // namespace
}  // namespace waymark::imports
