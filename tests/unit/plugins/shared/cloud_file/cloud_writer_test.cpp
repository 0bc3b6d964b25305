// SPDX-License-Identifier: Apache-2.0
// What is written is read again. Files that are damaged: tests of the source clouds.
#include "plugins/shared/cloud_file/cloud_writer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "plugins/shared/cloud_file/cloud_reader.hpp"
#include "temporary_folder.hpp"
#include "waymark/base/error.hpp"

namespace waymark::cloud_file {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// So many points; 30 000 are more than a piece of the reader's and the writer's.
PointCloud cloud_of(int points, bool intensities, bool times) {
  PointCloud cloud;
  for (int i = 0; i < points; ++i) {
    const auto x = static_cast<float>(i);
    cloud.points_m.emplace_back(0.1f * x, std::sin(x), 1e3f * std::cos(x));
    if (intensities) cloud.intensities.push_back(i == 1 ? std::numeric_limits<float>::quiet_NaN() : x);
    if (times) cloud.offsets_s.push_back(1e-5f * x);
  }
  return cloud;
}

struct Form {
  const char* name;
  bool intensities;
  bool times;
};

TEST(CloudWriter, WhatItWritesIsReadAgain) {
  const test::TemporaryFolder folder;
  for (const Form& form : {Form{"a.bin", false, false}, Form{"b.bin", true, false}, Form{"c.bin.gz", false, true},
                           Form{"d.bin.gz", true, true}}) {
    const std::filesystem::path file = folder / form.name;
    std::vector<PointCloud> clouds;
    for (const int points : {30'000, 0, 2}) clouds.push_back(cloud_of(points, form.intensities, form.times));
    constexpr std::int64_t kStart = 1'630'577'758'569'490'001;
    CloudWriter writer(file, {3, form.intensities, form.times});
    for (std::int64_t k = 0; k < 3; ++k) writer.add(Time{Duration{kStart + k}}, clouds[static_cast<std::size_t>(k)]);
    writer.finish();

    CloudReader reader(file);
    EXPECT_EQ(reader.clouds(), 3U);
    for (const PointCloud& given : clouds) {
      const auto head = reader.next();
      ASSERT_TRUE(head && head->stamp);
      EXPECT_EQ(head->stamp->time_since_epoch().count(), kStart + head->number);
      PointCloud again;
      EXPECT_EQ(reader.read({}, again), 0U);
      EXPECT_EQ(again.points_m, given.points_m);
      EXPECT_EQ(again.offsets_s, given.offsets_s);
      ASSERT_EQ(again.intensities.size(), given.intensities.size());
      for (std::size_t i = 0; i < given.intensities.size(); ++i) {
        const bool both_unknown = std::isnan(again.intensities[i]) && std::isnan(given.intensities[i]);
        EXPECT_TRUE(both_unknown || again.intensities[i] == given.intensities[i]) << i;
      }
    }
    EXPECT_FALSE(reader.next());
  }
}

TEST(CloudWriter, RefusesWhatItsHeadDoesNotState) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "clouds.bin";
  const auto attempt = [&](const CloudWriter::Contents& contents,
                           const std::vector<std::pair<int, PointCloud>>& clouds) {
    CloudWriter writer(file, contents);
    for (const auto& [t, cloud] : clouds) writer.add(Time{Duration{t}}, cloud);
    writer.finish();
  };
  const PointCloud plain = cloud_of(2, false, false);
  EXPECT_THAT([&] { attempt({2}, {{1, plain}}); }, ThrowsMessage<DataError>(HasSubstr("has 1 clouds; 2 were stated")));
  EXPECT_THAT(
      [&] {
        attempt({1}, {{1, plain}, {2, plain}});
      },
      ThrowsMessage<DataError>(HasSubstr("cloud 1: is one more")));
  EXPECT_THAT(
      [&] {
        attempt({2}, {{1, plain}, {1, plain}});
      },
      ThrowsMessage<DataError>(HasSubstr("is not later than")));
  EXPECT_THAT(
      [&] {
        attempt({1, true}, {{1, plain}});
      },
      ThrowsMessage<DataError>(HasSubstr("2 points have 0 intensities")));
  EXPECT_THAT(
      [&] {
        attempt({1}, {{1, cloud_of(2, false, true)}});
      },
      ThrowsMessage<DataError>(HasSubstr("2 points have 2 times")));
  EXPECT_FALSE(std::filesystem::exists(file));
}

}  // namespace
}  // namespace waymark::cloud_file
