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

/// 30 000 points, which are more than a piece of the reader's or the writer's, with what `contents` says.
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

TEST(CloudWriter, WhatItWritesIsReadAgain) {
  const test::TemporaryFolder folder;
  for (const char* name : {"clouds.bin", "clouds.bin.gz"}) {
    for (const bool intensities : {false, true}) {
      for (const bool times : {false, true}) {
        const std::filesystem::path file = folder / name;
        const std::vector<PointCloud> clouds{cloud_of(30'000, intensities, times), cloud_of(0, intensities, times),
                                             cloud_of(2, intensities, times)};
        CloudWriter writer(file, {3, intensities, times});
        for (int k = 0; k < 3; ++k)
          writer.add(Time{Duration{1'630'577'758'569'490'001 + k}}, clouds[static_cast<std::size_t>(k)]);
        writer.finish();

        CloudReader reader(file);
        EXPECT_EQ(reader.clouds(), 3U);
        for (int k = 0; k < 3; ++k) {
          const auto head = reader.next();
          ASSERT_TRUE(head && head->stamp);
          EXPECT_EQ(head->stamp->time_since_epoch().count(), 1'630'577'758'569'490'001 + k);
          PointCloud again;
          EXPECT_EQ(reader.read({}, again), 0U);
          const PointCloud& given = clouds[static_cast<std::size_t>(k)];
          EXPECT_EQ(again.points_m, given.points_m);
          EXPECT_EQ(again.offsets_s, given.offsets_s);
          ASSERT_EQ(again.intensities.size(), given.intensities.size());
          for (std::size_t i = 0; i < given.intensities.size(); ++i) {
            EXPECT_TRUE(again.intensities[i] == given.intensities[i] ||
                        (std::isnan(again.intensities[i]) && std::isnan(given.intensities[i])));
          }
        }
        EXPECT_FALSE(reader.next());
      }
    }
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
