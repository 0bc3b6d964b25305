// SPDX-License-Identifier: Apache-2.0
#include "waymark/config/key_reference.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "waymark/base/error.hpp"

namespace waymark {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

const DescribedKey& find(const std::vector<DescribedKey>& keys, const std::string& path) {
  const DescribedKey* key = find_key(keys, path);
  if (key == nullptr) throw std::runtime_error("no key " + path);
  return *key;
}

std::vector<std::string> paths(const std::vector<DescribedKey>& keys) {
  std::vector<std::string> result;
  for (const DescribedKey& key : keys) result.push_back(key.asked.path);
  return result;
}

TEST(Asked, IsWhatWasDeclaredAtTheRead) {
  const Config config = Config::parse("sigma_m: 0.5\nlist: [1, 2, 3]\n");
  config.positive({"sigma_m", "m", "noise per axis"});
  config.number_in({"angle_deg", "°", "of the sensor"}, -90.0, 90.0, 30.0);
  config.choice({"mode", "how"}, {"fast", "slow"}, "fast");
  config.numbers("list", 3);
  config.integer_in({"count", "", "of many", "as many as needed"}, 1, 9, 2);
  const std::vector<Config::Asked> asked = config.asked();
  ASSERT_EQ(asked.size(), 5U);
  EXPECT_EQ(asked[0].path, "sigma_m");
  EXPECT_EQ(asked[0].unit, "m");
  EXPECT_EQ(asked[0].meaning, "noise per axis");
  EXPECT_EQ(asked[0].expectation(), "number > 0");
  EXPECT_TRUE(asked[0].is_required);
  EXPECT_EQ(asked[0].fallback, std::nullopt);
  EXPECT_EQ(asked[1].expectation(), "number in [-90, 90]");
  EXPECT_EQ(asked[1].fallback, "30");
  EXPECT_FALSE(asked[1].is_required);
  EXPECT_EQ(asked[2].expectation(), "one of: fast, slow");
  EXPECT_EQ(asked[3].expectation(), "list of 3 numbers");
  EXPECT_EQ(asked[4].expectation(), "whole number in [1, 9]");
  EXPECT_EQ(asked[4].fallback, "as many as needed");
}

TEST(Asked, ReachesIntoMappingsAndLists) {
  const Config config = Config::parse("block: { a: 1 }\nfiles: [{ path: x }, { path: y }]\n");
  config.child("block").number({"a", "first"});
  for (const Config& file : config.items("files")) file.text("path");
  std::vector<std::string> found;
  for (const Config::Asked& key : config.asked()) found.push_back(key.path);
  EXPECT_THAT(found, ElementsAre("block", "block.a", "files", "files[].path", "files[].path"));
}

TEST(DescribeKeys, FillsInWhatIsRequired) {
  const auto keys = describe_keys([](const Config& config) {
    config.positive({"sigma_m", "m", "noise"});
    config.items("files").at(0).text("path");
    config.child("course").numbers("waypoints_m");
    config.number("last", 0.0);
  });
  EXPECT_THAT(paths(keys), ElementsAre("sigma_m", "files", "files[].path", "course", "course.waypoints_m", "last"));
  EXPECT_TRUE(find(keys, "sigma_m").asked.is_required);
  EXPECT_THAT(find(keys, "last").given, IsEmpty());
}

TEST(DescribeKeys, FindsWhatOnlyAnotherChoiceReads) {
  const auto keys = describe_keys([](const Config& config) {
    const std::string model = config.choice("model", {"wheels", "car"});
    if (model == "wheels") {
      config.positive("track_m");
      return;
    }
    config.positive("wheelbase_m");
    if (config.boolean("steers_behind", false)) config.number("offset_m", 0.0);
  });
  EXPECT_THAT(paths(keys),
              ::testing::UnorderedElementsAre("model", "track_m", "wheelbase_m", "steers_behind", "offset_m"));
  EXPECT_THAT(find(keys, "track_m").given, IsEmpty());
  EXPECT_THAT(find(keys, "wheelbase_m").given, ElementsAre("model=car"));
  EXPECT_THAT(find(keys, "offset_m").given, ElementsAre("model=car", "steers_behind=true"));
}

TEST(DescribeKeys, WhatOneOfSeveralKeysRevealsDependsOnNone) {
  const auto keys = describe_keys([](const Config& config) {
    const bool has_angle = config.has("angle_deg");
    if (has_angle) config.number({"angle_deg", "as it is"});
    if (!has_angle && config.choice({"angle", "or where it is from"}, {"unknown", "auto"}, "unknown") == "unknown")
      return;
    config.number("sigma_deg", 5.0);
    if (has_angle) config.number("offset_deg", 0.0);
  });
  EXPECT_THAT(find(keys, "sigma_deg").given, IsEmpty());
  EXPECT_THAT(find(keys, "offset_deg").given, ElementsAre("angle_deg=1"));
}

TEST(DescribeKeys, AKeyThatIsReadOnlyWhereItIsGivenIsOptional) {
  const auto keys = describe_keys([](const Config& config) {
    if (!config.has("velocity_sigma_mps")) return;
    config.positive({"velocity_sigma_mps", "m/s", "noise of the velocity"});
    config.positive("least_speed_mps", 1.0);
  });
  EXPECT_FALSE(find(keys, "velocity_sigma_mps").asked.is_required);
  EXPECT_EQ(find(keys, "velocity_sigma_mps").asked.expectation(), "number > 0");
  EXPECT_EQ(find(keys, "least_speed_mps").asked.fallback, "1");
}

TEST(DescribeKeys, ANumberThatSwitchesSomethingOnIsTried) {
  const auto keys = describe_keys([](const Config& config) {
    if (config.non_negative("offset_sigma_m", 0.0) > 0.0) config.positive("offset_tau_s", 30.0);
  });
  EXPECT_THAT(paths(keys), ElementsAre("offset_sigma_m", "offset_tau_s"));
}

TEST(DescribeKeys, AReaderThatThrowsEndsOneTrialOnly) {
  const auto keys = describe_keys([](const Config& config) {
    if (config.boolean("with_lists", true)) throw std::runtime_error("lists are not there");
    config.texts("names");
  });
  EXPECT_THAT(paths(keys), ElementsAre("with_lists", "names"));
}

TEST(DescribeKeys, TriesWithWhatTheCallerGives) {
  KeyTrials trials;
  trials.given = {"inputs=[lidar, camera]"};
  trials.texts = {"no", "yes"};
  const auto keys = describe_keys(
      [](const Config& config) {
        if (config.texts("inputs").size() == 2) config.child_or_empty("camera").number("edge", 1.0);
        if (config.text("answer") == "yes") config.number("more", 0.0);
      },
      trials);
  EXPECT_THAT(paths(keys), ElementsAre("inputs", "camera", "camera.edge", "answer", "more"));
}

TEST(DescribeKeys, KeysThatAreNotAllFoundAreAnError) {
  KeyTrials trials;
  trials.most = 100;
  const auto ask_deeper_each_time = [](const Config& config) {
    std::string key = "a";
    while (config.boolean(key, false)) key += "a";
  };
  EXPECT_THAT([&] { describe_keys(ask_deeper_each_time, trials); },
              testing::ThrowsMessage<Error>(testing::HasSubstr("after 100 configurations")));
}

}  // namespace
}  // namespace waymark
