// SPDX-License-Identifier: Apache-2.0
#include "merged_source.hpp"

#include <gmock/gmock.h>

#include "scripted_source.hpp"

namespace waymark::host {
namespace {

using testing::ElementsAre;

TEST(MergedSource, DeliversInOrderOfArrivalWithChannelsInOrderOfSources) {
  const auto a = std::make_shared<Scripted>(std::vector<std::string>{"wheels", "gyro"},
                                            std::vector{reading(1.0), reading(2.0, 1), reading(5.0)});
  const auto b = std::make_shared<Scripted>(std::vector<std::string>{"gps"}, std::vector{reading(2.0), reading(3.0)});
  MergedSource merged({a, b});
  ASSERT_EQ(merged.channels().size(), 3U);
  EXPECT_EQ(merged.channels()[2].sensor, "gps");
  std::vector<std::pair<double, std::uint32_t>> seen;
  std::uint64_t sequence = 0;
  while (const auto m = merged.next()) {
    seen.emplace_back(to_seconds(m->arrival.time_since_epoch()), m->sensor);
    EXPECT_EQ(m->sequence, sequence++);
  }
  EXPECT_THAT(seen, ElementsAre(std::pair(1.0, 0U), std::pair(2.0, 1U), std::pair(2.0, 2U), std::pair(3.0, 2U),
                                std::pair(5.0, 0U)));
  EXPECT_FALSE(merged.next());
}

}  // namespace
}  // namespace waymark::host
