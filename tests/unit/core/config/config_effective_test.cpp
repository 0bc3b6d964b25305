// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>

#include "waymark/base/error.hpp"
#include "waymark/config/config.hpp"

namespace waymark {
namespace {

TEST(ConfigEffective, ShowsGivenValuesAndMarksDefaults) {
  const Config config = Config::parse("filter:\n  particles: 25\nsensors:\n  - name: gps\n    sigma_m: 0.050\n");
  const Config filter = config.child("filter");
  filter.integer("particles");
  filter.integer("seed", 1);
  const Config gps = config.items("sensors")[0];
  gps.text("name");
  gps.number("sigma_m");
  gps.numbers("base_p_antenna_m", 3, {0.0, 0.5, 0.0});
  config.child_or_empty("output").boolean("compress", false);
  config.items_or_empty("sinks");
  EXPECT_EQ(config.effective(),
            "filter:\n"
            "  particles: 25\n"
            "  seed: 1  # default\n"
            "sensors:\n"
            "  - name: gps\n"
            "    sigma_m: 0.05\n"
            "    base_p_antenna_m: [0, 0.5, 0]  # default\n"
            "output:\n"
            "  compress: false  # default\n"
            "sinks: []  # default\n");
}

TEST(ConfigEffective, HasNoVariables) {
  const Config config = Config::parse("variables: { folder: logs }\nfile: ${folder}/a.csv\n");
  EXPECT_EQ(config.effective(), "file: logs/a.csv\n");
}

/// What a reader takes from the configuration of the round trip.
std::vector<std::string> all_values(const Config& config) {
  std::vector<std::string> values;
  const auto add = [&values](double value) { values.push_back(std::to_string(value)); };
  add(config.number("third"));
  add(config.number("tiny", 1e-40));
  add(config.number("default_third", 1.0 / 3.0));
  values.push_back(std::to_string(config.integer("big", std::numeric_limits<std::int64_t>::max())));
  values.push_back(config.boolean("on") ? "on" : "off");
  for (const char* key :
       {"quoted", "odd", "colon", "lines", "null_text", "empty", "dollar", "dash", "from_environment"}) {
    values.push_back(config.text(key));
  }
  values.push_back(config.text("fallback", "a: b # c"));
  for (const std::string& word : config.texts("words", {"x, y", "[z]"})) values.push_back(word);
  for (const double number : config.numbers("list", 2)) add(number);
  for (const Config& item : config.items("items")) {
    values.push_back(item.text("name"));
    for (const Config& inner : item.items_or_empty("inner")) add(inner.child("deep").number("x", 4.5));
    add(item.child_or_empty("defaults").number("y", 2.5));
  }
  values.push_back(std::to_string(config.items("pair").size()));
  config.child("nothing");
  return values;
}

TEST(ConfigEffective, LoadsAgainToTheSameValues) {
  setenv("WAYMARK_TEST_ODD", "~", 1);
  const Config config = Config::parse(
      "third: 0.33333333333333331\non: yes\nquoted: \"5\"\nodd: 'it''s \"x\" \\ y'\ncolon: \"a: b\"\n"
      "lines: \"one\\ntwo\\tthree\"\nnull_text: \"null\"\nempty: \"\"\ndollar: \"$${x} $$${y}\"\ndash: \"- a\"\n"
      "from_environment: ${WAYMARK_TEST_ODD}\nlist: [1e3, -0.5]\n"
      "items:\n  - name: a b\n    inner: [{ deep: { x: 1 } }, { deep: {} }]\n  - { name: c, inner: [] }\npair: [{}, "
      "{}]\nnothing: {}\n");
  unsetenv("WAYMARK_TEST_ODD");
  const std::vector<std::string> values = all_values(config);
  config.reject_unread();
  const std::string text = config.effective();
  const Config again = Config::parse(text);
  EXPECT_EQ(all_values(again), values) << text;
  EXPECT_NO_THROW(again.reject_unread()) << text;
  EXPECT_EQ(again.number("third"), 1.0 / 3.0);
  EXPECT_EQ(again.number("default_third"), 1.0 / 3.0);
  EXPECT_EQ(again.number("tiny"), 1e-40);
}

TEST(ConfigEffective, AKeyHoldsNoVariables) {
  const Config config = Config::parse("\"a ${b} $$\": 1\n");
  EXPECT_EQ(Config::parse(config.effective()).keys(), config.keys()) << config.effective();
}

TEST(ConfigEffective, ShowsAnInfiniteDefaultAsAComment) {
  const Config config = Config::parse("a: 1");
  config.number("max_age_s", std::numeric_limits<double>::infinity());
  EXPECT_EQ(config.effective(), "a: 1\n# max_age_s: inf  # default\n");
  EXPECT_FALSE(Config::parse(config.effective()).has("max_age_s"));
}

TEST(ConfigEffective, DoesNotInventEmptyMappings) {
  const Config config = Config::parse("items: [{}]");
  config.items("items")[0].child_or_empty("gate").child_or_empty("deep").number(
      "x", std::numeric_limits<double>::infinity());
  EXPECT_EQ(config.effective(), "items:\n  - {}\n");
}

TEST(ConfigEffective, HasWhatAWordStandsForOnceThatIsSettled) {
  const Config config = Config::parse("a: { where: from_tf }");
  const Config entry = config.child("a");
  EXPECT_TRUE(entry.is_word("where", "from_tf"));
  EXPECT_FALSE(entry.is_word("where", "anywhere"));
  entry.replace("where", "{ x_m: 0.25 }");
  EXPECT_EQ(entry.child("where").number("x_m"), 0.25);
  EXPECT_EQ(config.effective(), "a:\n  where:\n    x_m: 0.25\n");
  EXPECT_THROW(entry.replace("where", "{ x_m: [ }"), ConfigError);
  EXPECT_THROW(entry.replace("nowhere", "1"), ConfigError);
}

TEST(ConfigEffective, OfNothingIsAnEmptyMapping) { EXPECT_EQ(Config::parse("").effective(), "{}\n"); }

}  // namespace
}  // namespace waymark
