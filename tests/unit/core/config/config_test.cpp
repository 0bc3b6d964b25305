// SPDX-License-Identifier: Apache-2.0
#include "waymark/config/config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "temporary_folder.hpp"

namespace waymark {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(Config, ReadsScalars) {
  const Config config = Config::parse("a: 1.5\nb: 1e3\nc: -7\nd: yes\ne: some words\nf: +2\ng: Off\nh: 1e3\ni: 5\n");
  EXPECT_EQ(config.number("a"), 1.5);
  EXPECT_EQ(config.number("b"), 1000.0);
  EXPECT_EQ(config.integer("c"), -7);
  EXPECT_TRUE(config.boolean("d"));
  EXPECT_EQ(config.text("e"), "some words");
  EXPECT_EQ(config.positive("f"), 2.0);
  EXPECT_FALSE(config.boolean("g", true));
  EXPECT_EQ(config.integer("h"), 1000);
  EXPECT_EQ(config.text("i"), "5");
}

TEST(Config, FallsBackForAbsentKeysOnly) {
  const Config config = Config::parse("given: 2");
  EXPECT_EQ(config.number("given", 1.0), 2.0);
  EXPECT_EQ(config.number("number", 1.0), 1.0);
  EXPECT_EQ(config.positive("positive", 3.0), 3.0);
  EXPECT_EQ(config.non_negative("non_negative", 0.0), 0.0);
  EXPECT_EQ(config.number_in("in", 0.0, 1.0, 0.5), 0.5);
  EXPECT_EQ(config.integer("integer", 4), 4);
  EXPECT_TRUE(config.boolean("boolean", true));
  EXPECT_EQ(config.text("text", "x"), "x");
  EXPECT_EQ(config.choice("choice", {"a", "b"}, "b"), "b");
  EXPECT_THAT(config.numbers("numbers", 2, {1.0, 2.0}), ElementsAre(1.0, 2.0));
  EXPECT_THAT(config.texts("texts", {"a"}), ElementsAre("a"));
  EXPECT_EQ(config.number("number", 7.0), 7.0) << "a fallback that was noted is not a given value";
}

TEST(Config, ReadsLists) {
  const Config config = Config::parse("a: [1, 2.5, -3]\nb: [x, y]\nc: one\nd: []\n");
  EXPECT_THAT(config.numbers("a", 3), ElementsAre(1.0, 2.5, -3.0));
  EXPECT_THAT(config.texts("b"), ElementsAre("x", "y"));
  EXPECT_THAT(config.texts("c"), ElementsAre("one"));
  EXPECT_THAT(config.numbers("d"), IsEmpty());
}

TEST(Config, WalksTheStructure) {
  const Config config = Config::parse(
      "filter: { seed: 3 }\nsensors:\n  - { name: gps, sigma_m: 1 }\n  - { plugin: tum }\n  - { x: 1 }\nempty:\n");
  EXPECT_EQ(config.child("filter").integer("seed"), 3);
  const std::vector<Config> sensors = config.items("sensors");
  ASSERT_EQ(sensors.size(), 3u);
  EXPECT_EQ(sensors[0].path(), "sensors.gps");
  EXPECT_EQ(sensors[1].path(), "sensors.tum");
  EXPECT_EQ(sensors[2].path(), "sensors[2]");
  EXPECT_EQ(config.child_or_empty("absent").number("x", 4.0), 4.0);
  EXPECT_THAT(config.items_or_empty("nothing"), IsEmpty());
  EXPECT_THAT(config.child("empty").keys(), IsEmpty());
  EXPECT_THAT(config.keys(), ElementsAre("filter", "sensors", "empty"));
  EXPECT_TRUE(config.is_mapping("filter"));
  EXPECT_TRUE(config.is_list("sensors"));
  EXPECT_FALSE(config.has("absent"));
}

TEST(Config, AnEmptyTextIsAnEmptyMapping) {
  EXPECT_THAT(Config::parse("").keys(), IsEmpty());
  EXPECT_THAT(Config::parse("# only a comment\n").keys(), IsEmpty());
}

TEST(ConfigVariables, AreReplacedInTextAndAsAWhole) {
  const Config config = Config::parse(
      "variables: { log: car_park, folder: \"data/${log}\", position: [1, 2], count: 7, quoted: \"8\" }\n"
      "file: ${folder}/gps.csv\nat: ${position}\ncount: \"${count}\"\nlist: [\"${log}\"]\nquoted: ${quoted}\n");
  EXPECT_EQ(config.text("file"), "data/car_park/gps.csv");
  EXPECT_THAT(config.numbers("at", 2), ElementsAre(1.0, 2.0));
  EXPECT_EQ(config.integer("count"), 7);
  EXPECT_THAT(config.texts("list"), ElementsAre("car_park"));
  EXPECT_EQ(config.integer("quoted"), 8);
  EXPECT_FALSE(config.has("variables"));
  EXPECT_NO_THROW(config.reject_unread());
}

TEST(ConfigVariables, AMappingKeepsItsShape) {
  const Config config = Config::parse("variables: { mount: { xyz_m: [1, 2, 3] } }\nlidar: ${mount}\n");
  EXPECT_THAT(config.child("lidar").numbers("xyz_m", 3), ElementsAre(1.0, 2.0, 3.0));
}

TEST(ConfigVariables, ComeFromTheEnvironmentInCapitals) {
  setenv("WAYMARK_TEST_FOLDER", "some/where", 1);
  const Config config = Config::parse("file: ${WAYMARK_TEST_FOLDER}/x.csv");
  EXPECT_EQ(config.text("file"), "some/where/x.csv");
  EXPECT_EQ(Config::parse("variables: { WAYMARK_TEST_FOLDER: mine }\na: ${WAYMARK_TEST_FOLDER}").text("a"), "mine");
  unsetenv("WAYMARK_TEST_FOLDER");
}

TEST(ConfigVariables, UnusedOnesAreNotResolved) {
  EXPECT_EQ(Config::parse("variables: { a: \"${WAYMARK_TEST_UNSET}\" }\nb: 1").integer("b"), 1);
}

TEST(ConfigVariables, ADoubledDollarIsLiteral) { EXPECT_EQ(Config::parse("a: x$${b}$c").text("a"), "x${b}$c"); }

TEST(ConfigOverrides, ReplaceAndCreateValues) {
  const Config config =
      Config::parse("filter: { particles: 25 }", "text", {"filter.particles=100", "output.rate_hz=5", "list=[1, 2]"});
  EXPECT_EQ(config.child("filter").integer("particles"), 100);
  EXPECT_EQ(config.child("output").number("rate_hz"), 5.0);
  EXPECT_THAT(config.numbers("list"), ElementsAre(1.0, 2.0));
}

TEST(ConfigOverrides, FindElementsByNamePluginAndIndex) {
  const Config config =
      Config::parse("sensors: [{name: gps, sigma_m: 1}]\nsinks: [{plugin: tum}, {plugin: plot}]", "text",
                    {"sensors.gps.sigma_m=0.1", "sinks.plot.width=9", "sinks.0.plugin=landmarks"});
  EXPECT_EQ(config.items("sensors")[0].number("sigma_m"), 0.1);
  EXPECT_EQ(config.items("sinks")[0].text("plugin"), "landmarks");
  EXPECT_EQ(config.items("sinks")[1].integer("width"), 9);
}

TEST(ConfigOverrides, ReplaceWholeLists) {
  const Config config =
      Config::parse("sinks: [{plugin: tum}, {plugin: plot}]", "text", {"sinks=[{plugin: landmarks}]"});
  const std::vector<Config> sinks = config.items("sinks");
  ASSERT_EQ(sinks.size(), 1u);
  EXPECT_EQ(sinks[0].text("plugin"), "landmarks");
  EXPECT_THAT(Config::parse("maps: [{name: a}]", "text", {"maps=[]"}).items("maps"), IsEmpty());
}

TEST(ConfigOverrides, ComeBeforeVariables) {
  const Config config = Config::parse("variables: { n: 1, m: \"${WAYMARK_TEST_UNSET}\" }\na: ${n}\nb: ${m}", "text",
                                      {"variables.n=2", "variables.m=3"});
  EXPECT_EQ(config.integer("a"), 2);
  EXPECT_EQ(config.integer("b"), 3);
}

TEST(ConfigOverrides, MayUseVariables) {
  EXPECT_EQ(Config::parse("variables: { n: 4 }\na: 1", "text", {"a=${n}"}).integer("a"), 4);
}

TEST(ConfigOverrides, KeepEverythingBehindTheFirstEqualsSign) {
  EXPECT_EQ(Config::parse("a: 1", "text", {"a=x=y"}).text("a"), "x=y");
}

TEST(ConfigReads, RejectUnreadPassesWhenAllIsRead) {
  const Config config = Config::parse("a: 1\nb: { c: [{ d: 1 }] }");
  config.number("a");
  config.child("b").items("c")[0].number("d");
  EXPECT_NO_THROW(config.reject_unread());
}

TEST(ConfigReads, IgnoreCoversAllBelow) {
  const Config config = Config::parse("sinks: [{ plugin: plot, deep: { x: 1 } }]");
  config.items("sinks")[0].ignore();
  EXPECT_NO_THROW(config.reject_unread());
}

TEST(ConfigReads, LookingIsNotReading) {
  const Config config = Config::parse("a: { b: 1 }");
  EXPECT_TRUE(config.has("a"));
  EXPECT_TRUE(config.is_mapping("a"));
  EXPECT_FALSE(config.is_list("a"));
  EXPECT_THAT(config.keys(), ElementsAre("a"));
  EXPECT_THROW(config.reject_unread(), ConfigError);
}

TEST(ConfigReads, AnAliasIsACopy) {
  const Config config = Config::parse("a: &x { v: 1 }\nb: *x");
  config.child("a").number("v");
  config.child("b");
  EXPECT_THROW(config.reject_unread(), ConfigError);
  EXPECT_EQ(config.child("b").number("v"), 1.0);
}

TEST(ConfigLoad, ReadsAFileAndKnowsItsPath) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "robot.yaml";
  std::ofstream(file) << "a:\n  b: 2\n";
  const Config config = Config::load(file, {"a.c=3"});
  EXPECT_EQ(config.file(), file);
  EXPECT_EQ(config.child("a").file(), file);
  EXPECT_EQ(config.child("a").integer("b"), 2);
  EXPECT_EQ(config.child("a").place(), file.string() + ":2:3");
}

}  // namespace
}  // namespace waymark
