// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "waymark/config/config.hpp"

namespace waymark {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(ConfigOutput, IsANameBelowTheFolder) {
  const Config config = Config::parse("{ a: map.png, b: maps/./best.pgm }");
  EXPECT_EQ(config.output("a", ""), "map.png");
  EXPECT_EQ(config.output("b", ""), "maps/./best.pgm");
  EXPECT_EQ(config.output("c", "default.txt"), "default.txt");
}

TEST(ConfigOutput, OutsideOfTheFolderIsRefusedUnlessPermitted) {
  for (const char* name : {"/tmp/x", "../x", "a/../../x", ".", "''"}) {
    const Config config = Config::parse(std::string("{ file: ") + name + " }");
    EXPECT_THROW(config.output("file", ""), ConfigError) << name;
    config.permit_outside();
    EXPECT_NO_THROW(config.output("file", "")) << name;
  }
}

TEST(ConfigOutput, EachFileIsWrittenByOneKey) {
  const Config config = Config::parse("sinks: [{ plugin: tum }, { plugin: plot, file: ./map.png }, { plugin: plot }]");
  const std::vector<Config> sinks = config.items("sinks");
  sinks[0].output("trajectory", "trajectory.txt");
  sinks[1].output("file", "map.png");
  EXPECT_EQ(sinks[1].output("file", "map.png"), "./map.png") << "the same key, read again";
  EXPECT_THAT([&] { sinks[2].output("file", "map.png"); },
              ThrowsMessage<ConfigError>(AllOf(HasSubstr("\"map.png\" is also written by sinks.plot.file"))));
  EXPECT_THROW(sinks[0].output("covariance", "map.png/x.csv"), ConfigError) << "a file cannot be a folder";
  EXPECT_THROW(sinks[0].output("path", "config.yaml"), ConfigError);
}

TEST(ConfigOutput, RefusesNamesThatNoFileShouldHave) {
  const auto refusal = [](const std::string& name) -> std::string {
    try {
      Config::parse("file: " + name, "f.yaml").output("file", "a.txt");
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal("\"a\\0b\""), "f.yaml:1:7: file: a file's name has no control characters");
  EXPECT_EQ(refusal("\"a\\nb\""), "f.yaml:1:7: file: a file's name has no control characters");
  EXPECT_EQ(refusal("a.txt.partial"),
            "f.yaml:1:7: file: \"a.txt.partial\": names that end in .partial are of files that are not complete");
  EXPECT_EQ(refusal("partial"), "");
}

}  // namespace
}  // namespace waymark
