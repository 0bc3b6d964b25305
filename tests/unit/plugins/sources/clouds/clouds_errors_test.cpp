// SPDX-License-Identifier: Apache-2.0
// needs plugins: csv
// Damaged files of clouds, and wrong keys.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "source_error.hpp"
#include "unit/plugins/sources/clouds/clouds_fixture.hpp"
#include "unit/plugins/sources/csv/csv_fixture.hpp"
#include "waymark/base/error.hpp"

namespace waymark::clouds_test {
namespace {

using ::testing::HasSubstr;

class CloudsErrors : public CloudsTest {
 protected:
  /// How many clouds come before the error, and its text.
  std::pair<int, std::string> clouds_and_error(const std::string& more = "") const {
    const auto source = make(more);
    int clouds = 0;
    try {
      while (source->next()) ++clouds;
    } catch (const DataError& error) {
      return {clouds, error.what()};
    }
    ADD_FAILURE() << "no error";
    return {clouds, ""};
  }
  std::string refusal(const std::string& more = "") const {
    return test::source_error<ConfigError>([&] { return make(more); });
  }
};

TEST_F(CloudsErrors, AFileThatIsNoneIsRefusedAtItsKey) {
  write("PTS3000");
  EXPECT_THAT(refusal(), HasSubstr("run.yaml:1:"));
  EXPECT_THAT(refusal(), HasSubstr("file: "));
  EXPECT_THAT(refusal(), HasSubstr("clouds.bin: is no file of clouds: it does not begin with PTS30001 or PTS30002"));
  write("");
  EXPECT_THAT(refusal(), HasSubstr("is no file of clouds"));
  write("SCN20001 and more");
  EXPECT_THAT(refusal(), HasSubstr("holds planar scans (SCN2…), no clouds; the source csv reads such ones"));
  write("PTS30001\1");
  EXPECT_THAT(refusal(), HasSubstr("the file ends within the head of the file"));
  write(std::string_view("\x1f\x8b\x08\x00", 4));
  EXPECT_THAT(refusal(), HasSubstr("the gzip stream ends early"));
  write(full_head(0, 4));
  EXPECT_THAT(refusal(), HasSubstr("its points have numbers of an unknown kind (0x4); at most 0x3 is expected"));
}

TEST_F(CloudsErrors, MoreCloudsThanTheFileCanHoldAreNotBelieved) {
  write(compact_head(4'000'000'000U) + compact_cloud(1.0, row_of(2)));
  EXPECT_THAT(refusal(), HasSubstr("states 4000000000 clouds, more than it can hold"));
  write(csv_test::gzip(compact_head(4'000'000'000U)));
  EXPECT_THAT(refusal(), HasSubstr("more than it can hold"));
}

TEST_F(CloudsErrors, MorePointsThanTheRestCanHoldAreNotBelieved) {
  const auto claim = [](std::uint32_t points) {
    return compact_head(2) + compact_cloud(1.0, row_of(2)) + raw(2.0) + raw(points) + std::string(12, '\0');
  };
  // Two points fit into the rest, three do not.
  write(claim(3));
  auto [clouds, error] = clouds_and_error();
  EXPECT_EQ(clouds, 1);
  EXPECT_THAT(error, HasSubstr("clouds.bin:cloud 1 (byte 48): states 3 points, more than the rest of the file can"));
  write(claim(2));
  EXPECT_EQ(read_all(*make()).size(), 2U);
  write(claim(0xffffffffU));
  EXPECT_THAT(clouds_and_error().second, HasSubstr("states 4294967295 points; at most 16777216 are expected"));
  // gzip: the rest expands to at most 1032 times its size.
  write(csv_test::gzip(claim(1U << 24)));
  EXPECT_THAT(clouds_and_error().second, HasSubstr("states 16777216 points, more than the rest of the file can hold"));
}

TEST_F(CloudsErrors, ACutFileGivesWhatItHasAndSaysWhereItEnds) {
  const std::string whole = compact_head(2) + compact_cloud(1.0, row_of(2)) + compact_cloud(2.0, row_of(2));
  write(whole.substr(0, whole.size() - 16));
  auto [clouds, error] = clouds_and_error();
  EXPECT_EQ(clouds, 1);
  EXPECT_THAT(error, HasSubstr("clouds.bin:cloud 1 (byte 44): the file ends within the head of a cloud"));

  const std::string packed = csv_test::gzip(whole);
  write(packed.substr(0, packed.size() - 14));
  std::tie(clouds, error) = clouds_and_error();
  EXPECT_EQ(clouds, 1);
  EXPECT_THAT(error, HasSubstr("the gzip stream ends early"));

  write(compact_head(2) + compact_cloud(1.0, row_of(2)));
  EXPECT_EQ(clouds_and_error().first, 1);
}

TEST_F(CloudsErrors, ADamagedGzipStreamIsNoticedAtItsEnd) {
  std::string packed = csv_test::gzip(compact_head(1) + compact_cloud(1.0, row_of(2)));
  packed[packed.size() - 6] = static_cast<char>(packed[packed.size() - 6] + 1);  // its checksum
  write(packed);
  const auto [clouds, error] = clouds_and_error();
  EXPECT_EQ(clouds, 1);
  EXPECT_THAT(error, HasSubstr("the gzip stream is damaged"));
}

TEST_F(CloudsErrors, BytesBehindTheLastCloudAreAnError) {
  write(compact_head(1) + compact_cloud(1.0, row_of(2)) + "x");
  const auto [clouds, error] = clouds_and_error();
  EXPECT_EQ(clouds, 1);
  EXPECT_THAT(error, HasSubstr("the file goes on behind the last of the 1 clouds that it states"));
}

TEST_F(CloudsErrors, AStampThatIsNoneOrNotLaterMakesABadRecord) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  write(compact_head(5) + compact_cloud(nan, row_of(1)) + compact_cloud(2.0, row_of(2)) +
        compact_cloud(2.0, row_of(3)) + compact_cloud(1e300, row_of(1)) + compact_cloud(3.0, row_of(4)));
  const auto source = make("max_bad_records: 3");
  const auto all = read_all(*source);
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[1].as<PointCloud>().points_m.size(), 4U);
  ASSERT_EQ(source->bad_records().size(), 3U);
  EXPECT_THAT(source->bad_records()[0].place, HasSubstr("clouds.bin:cloud 0"));
  EXPECT_THAT(source->bad_records()[0].reason, HasSubstr("its time is no stamp"));
  EXPECT_THAT(source->bad_records()[1].place, HasSubstr("clouds.bin:cloud 2"));
  EXPECT_THAT(source->bad_records()[1].reason,
              HasSubstr("its stamp, 2.000000000, is not later than that of the cloud"));
  const auto [clouds, error] = clouds_and_error("max_bad_records: 2");
  EXPECT_EQ(clouds, 1);
  EXPECT_THAT(error, HasSubstr("max_bad_records allows 2"));

  write(full_head(1) + full_cloud(std::numeric_limits<std::int64_t>::min(), 0, {}));
  EXPECT_THAT(clouds_and_error().second, HasSubstr("its time is no stamp"));
}

TEST_F(CloudsErrors, PointsThatAreNotFiniteAreLeftOutAndCounted) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  write(full_head(1, 2) + full_cloud(5, 3, {nan, 0, 0, 0.25f, 2, 0, 0, nan, 3, 0, 0, 0.75f}));
  const auto source = make("max_bad_records: 1");
  const auto all = read_all(*source);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].as<PointCloud>().points_m.size(), 1U);
  EXPECT_EQ(all[0].as<PointCloud>().offsets_s.size(), 1U);
  EXPECT_THAT(source->bad_records().at(0).reason, HasSubstr("2 of 3 points are not finite and were left out"));
  EXPECT_THAT(clouds_and_error().second, HasSubstr("2 of 3 points"));
}

TEST_F(CloudsErrors, WrongRangesAreRefused) {
  write(compact_head(1) + compact_cloud(1.0, row_of(2)));
  EXPECT_THAT(refusal("first_cloud: 1"), HasSubstr("first_cloud: 1: the file has 1 clouds, counted from 0"));
  EXPECT_THAT(refusal("first_cloud: 2, last_cloud: 1"), HasSubstr("last_cloud: 1 is before first_cloud, 2"));
  EXPECT_THAT(refusal("start_s: 2, end_s: 1"), HasSubstr("end_s: is before start_s"));
  EXPECT_THAT(refusal("every_nth_point: 0"), HasSubstr("every_nth_point"));
  EXPECT_THAT(refusal("max_points: -1"), HasSubstr("max_points"));
}

}  // namespace
}  // namespace waymark::clouds_test
