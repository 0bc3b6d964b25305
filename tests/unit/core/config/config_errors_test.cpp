// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cstdlib>
#include <fstream>
#include <functional>

#include "temporary_folder.hpp"
#include "waymark/config/config.hpp"

namespace waymark {
namespace {

// It takes terabytes of addresses.
#if defined(__SANITIZE_ADDRESS__)
constexpr bool kAddressSanitizer = true;
#elif defined(__has_feature)
constexpr bool kAddressSanitizer = __has_feature(address_sanitizer);
#else
constexpr bool kAddressSanitizer = false;
#endif

std::string message_of(const std::function<void()>& act) {
  try {
    act();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

/// The error of parsing alone.
std::string parse_error(std::string_view yaml, const std::vector<Config::Override>& overrides = {}) {
  return message_of([&] { Config::parse(yaml, "f.yaml", overrides); });
}

/// The error of one read from the sensor `gps`.
template <class Read>
std::string read_error(const std::string& line, Read read) {
  const Config config = Config::parse("sensors:\n  - name: gps\n    " + line + "\n", "f.yaml");
  const Config gps = config.items("sensors")[0];
  gps.text("name");
  return message_of([&] { read(gps); });
}

TEST(ConfigErrors, NameTextThatIsNoNumber) {
  EXPECT_EQ(read_error("sigma_m: abc", [](const Config& c) { c.number("sigma_m"); }),
            "f.yaml:3:14: sensors.gps.sigma_m: \"abc\" is not a number");
  EXPECT_EQ(read_error("sigma_m: 1.5x", [](const Config& c) { c.number("sigma_m"); }),
            "f.yaml:3:14: sensors.gps.sigma_m: \"1.5x\" is not a number");
}

TEST(ConfigErrors, RefuseQuotedNumbers) {
  EXPECT_EQ(read_error("sigma_m: \"5\"", [](const Config& c) { c.number("sigma_m"); }),
            "f.yaml:3:14: sensors.gps.sigma_m: \"5\" is text, write it without quotes");
  EXPECT_EQ(read_error("on: 'true'", [](const Config& c) { c.boolean("on"); }),
            "f.yaml:3:9: sensors.gps.on: \"true\" is text, write it without quotes");
}

TEST(ConfigErrors, RefuseWhatIsNotFinite) {
  for (const char* value : {".inf", "-.inf", ".nan", "inf", "nan", "-Infinity", "+.INF"}) {
    EXPECT_EQ(read_error("x: " + std::string(value), [](const Config& c) { c.number("x"); }),
              "f.yaml:3:8: sensors.gps.x: " + std::string(value) + " must be finite");
  }
  EXPECT_NE(read_error("x: 1e999", [](const Config& c) { c.number("x"); }).find("1e999 is too large"),
            std::string::npos);
}

TEST(ConfigErrors, NameTheBound) {
  EXPECT_EQ(read_error("x: -1", [](const Config& c) { c.positive("x"); }), "f.yaml:3:8: sensors.gps.x: -1 must be > 0");
  EXPECT_EQ(read_error("x: 0", [](const Config& c) { c.positive("x", 1.0); }),
            "f.yaml:3:8: sensors.gps.x: 0 must be > 0");
  EXPECT_EQ(read_error("x: -1", [](const Config& c) { c.non_negative("x"); }),
            "f.yaml:3:8: sensors.gps.x: -1 must be >= 0");
  EXPECT_EQ(read_error("x: 2", [](const Config& c) { c.number_in("x", 0.0, 1.0); }),
            "f.yaml:3:8: sensors.gps.x: 2 must lie in [0, 1]");
  EXPECT_EQ(read_error("x: 0", [](const Config& c) { c.integer_in("x", 1, 9, 5); }),
            "f.yaml:3:8: sensors.gps.x: 0 must lie in [1, 9]");
}

TEST(ConfigErrors, RefuseFractionsForWholeNumbers) {
  EXPECT_EQ(read_error("n: 1.5", [](const Config& c) { c.integer("n"); }),
            "f.yaml:3:8: sensors.gps.n: 1.5 is not a whole number");
  EXPECT_NE(read_error("n: 99999999999999999999", [](const Config& c) { c.integer("n"); }).find("too large"),
            std::string::npos);
}

TEST(ConfigErrors, NameTheWrongKind) {
  EXPECT_EQ(read_error("x: [1]", [](const Config& c) { c.number("x"); }),
            "f.yaml:3:8: sensors.gps.x: a list is not a number");
  EXPECT_EQ(read_error("x: 5", [](const Config& c) { c.child("x"); }), "f.yaml:3:8: sensors.gps.x: 5 is not a mapping");
  EXPECT_EQ(read_error("x: word", [](const Config& c) { c.items("x"); }),
            "f.yaml:3:8: sensors.gps.x: \"word\" is not a list");
  EXPECT_EQ(read_error("x: [word]", [](const Config& c) { c.items("x"); }),
            "f.yaml:3:9: sensors.gps.x[0]: \"word\" is not a mapping");
  EXPECT_EQ(read_error("x: 5", [](const Config& c) { c.boolean("x"); }),
            "f.yaml:3:8: sensors.gps.x: 5 is not true or false");
}

TEST(ConfigErrors, NameAKeyWithoutAValue) {
  EXPECT_EQ(read_error("x:", [](const Config& c) { c.number("x", 1.0); }),
            "f.yaml:3:5: sensors.gps.x: has no value; a number is expected");
  EXPECT_EQ(read_error("x: ~", [](const Config& c) { c.text("x"); }),
            "f.yaml:3:5: sensors.gps.x: has no value; a text is expected");
}

TEST(ConfigErrors, NameTheLengthOfAList) {
  EXPECT_EQ(read_error("x: [1, 2]", [](const Config& c) { c.numbers("x", 3); }),
            "f.yaml:3:8: sensors.gps.x: has 2 elements; a list of 3 numbers is expected");
  EXPECT_EQ(read_error("x: [1, b, 2]", [](const Config& c) { c.numbers("x", 3); }),
            "f.yaml:3:12: sensors.gps.x[1]: \"b\" is not a number");
  EXPECT_EQ(read_error("x: 1", [](const Config& c) { c.numbers("x", 3); }),
            "f.yaml:3:8: sensors.gps.x: 1 is not a list of 3 numbers");
}

TEST(ConfigErrors, ListTheChoices) {
  EXPECT_EQ(read_error("model: akerman",
                       [](const Config& c) {
                         c.choice("model", {"differential", "ackermann"});
                       }),
            "f.yaml:3:12: sensors.gps.model: \"akerman\" is not one of: differential, ackermann");
}

TEST(ConfigErrors, GiveTheMeaningWhereAWordStandsForAValueOfAnotherKind) {
  EXPECT_EQ(read_error("arm: 0.5",
                       [](const Config& c) {
                         c.choice({"arm", "m", "the antenna in the base frame [x, y, z], or `none`"}, {"none"});
                       }),
            "f.yaml:3:10: sensors.gps.arm: \"0.5\" is not none, nor what else is expected: the antenna in the base "
            "frame [x, y, z], or none");
}

TEST(ConfigErrors, NameWhatIsMissing) {
  EXPECT_EQ(read_error("sigma: 1", [](const Config& c) { c.number("sigma_m"); }),
            "f.yaml:2:5: sensors.gps: sigma_m is missing; \"sigma\" is given: did you mean \"sigma_m\"?");
  EXPECT_EQ(read_error("other: 1", [](const Config& c) { c.number("sigma_m"); }),
            "f.yaml:2:5: sensors.gps: sigma_m is missing");
  EXPECT_EQ(message_of([] { Config::parse("a: 1", "f.yaml").child("filter"); }), "f.yaml:1:1: filter is missing");
}

TEST(ConfigErrors, AKeyThatIsAskedForIsNoMisspeltOne) {
  const auto read = [](const Config& c) {
    if (c.has("x_m") || c.has("y_m")) c.number("y_m");
  };
  EXPECT_EQ(read_error("x_m: 1", read), "f.yaml:2:5: sensors.gps: y_m is missing");
}

TEST(ConfigErrors, FailNamesPlaceAndKey) {
  const Config config = Config::parse("filter:\n  seed: 1\n", "f.yaml");
  const Config filter = config.child("filter");
  EXPECT_EQ(message_of([&] { filter.fail("seed", "is bad"); }), "f.yaml:2:9: filter.seed: is bad");
  EXPECT_EQ(message_of([&] { filter.fail("absent", "is bad"); }), "f.yaml:2:3: filter.absent: is bad");
  EXPECT_EQ(message_of([&] { filter.fail("is bad"); }), "f.yaml:2:3: filter: is bad");
  EXPECT_EQ(message_of([&] { config.child_or_empty("none").fail("is bad"); }), "f.yaml:1:1: none: is bad");
}

TEST(ConfigErrors, UnknownKeySuggestsTheNearest) {
  const auto read = [](const Config& c) {
    c.number("sigma_m", 1.0);
    c.number("rate_hz", 1.0);
    c.number("yaw_deg", 0.0);
    c.reject_unread();
  };
  EXPECT_EQ(read_error("sigmma_m: 1", read),
            "f.yaml:3:5: sensors.gps.sigmma_m: unknown key; did you mean \"sigma_m\"?");
  EXPECT_EQ(read_error("sgima_m: 1", read), "f.yaml:3:5: sensors.gps.sgima_m: unknown key; did you mean \"sigma_m\"?");
  EXPECT_EQ(read_error("rate_per_s: 1", read),
            "f.yaml:3:5: sensors.gps.rate_per_s: unknown key; did you mean \"rate_hz\"?");
  EXPECT_EQ(read_error("yaw: 1", read), "f.yaml:3:5: sensors.gps.yaw: unknown key; did you mean \"yaw_deg\"?");
  EXPECT_EQ(read_error("frobnicate: 1", read),
            "f.yaml:3:5: sensors.gps.frobnicate: unknown key; known here: name, sigma_m, rate_hz, yaw_deg");
}

TEST(ConfigErrors, UnknownKeyAtTheTop) {
  EXPECT_EQ(message_of([] {
              const Config config = Config::parse("fliter: {}\n", "f.yaml");
              config.child_or_empty("filter");
              config.reject_unread();
            }),
            "f.yaml:1:1: fliter: unknown key; did you mean \"filter\"?");
}

TEST(ConfigErrors, RefuseDuplicateKeys) {
  EXPECT_EQ(parse_error("a: 1\nb:\n  c: 1\n  d: 2\n  c: 3\n"),
            "f.yaml:5:3: b.c: the key is given twice; the first is at f.yaml:3:3");
}

TEST(ConfigErrors, PlaceWrongSyntax) {
  EXPECT_EQ(parse_error("a: 1\nb: [1, 2\n").rfind("f.yaml:", 0), 0u);
  EXPECT_EQ(parse_error("a: 1\n b: 2\n").rfind("f.yaml:2:", 0), 0u);
  EXPECT_NE(parse_error("a: { b: ${c} }\n").find("\"${name}\""), std::string::npos);
}

TEST(ConfigErrors, ExplainTypingErrorsOfYaml) {
  const auto expect = [](const std::string& yaml, const std::string& place, const std::string& meaning) {
    const std::string error = parse_error(yaml);
    EXPECT_TRUE(error.starts_with("f.yaml:" + place + ": ")) << error;
    EXPECT_TRUE(error.ends_with("; " + meaning)) << error;
  };
  const std::string tab = "there is a tab in the indentation; YAML wants blanks";
  expect("a:\n\tb: 1\n", "2:3", tab);
  expect("a:\n  b: 1\n  \tc: 2\n", "3:3", tab);
  expect("s:\n  - { a: 1\n  - { b: 2 }\n", "3:5", "before this place a { has no }, or a comma is missing");
  expect("s: { a: 1 b: 2 }\n", "1:12", "before this place a { has no }, or a comma is missing");
  expect("s:\n  a: [0, 1\n  b: 3\n", "3:4", "before this place a [ has no ], or a comma is missing");
  expect("s:\n  -name: gps\n    b: 3\n", "3:6", "line 2 needs a blank after its \"-\"");
  expect("s:\n  - name: a\n  -name: b\n", "3:3", "line 3 needs a blank after its \"-\"");
  EXPECT_EQ(parse_error("a: -5: 3\n"), "f.yaml:1:6: illegal map value");
}

TEST(ConfigErrors, RefuseWhatIsNoMapping) {
  EXPECT_EQ(parse_error("- 1\n- 2\n"), "f.yaml:1:1: a list is not a mapping of keys to values");
  EXPECT_EQ(parse_error("a: 1\n---\nb: 2\n"), "f.yaml: has several documents (---), one is expected");
}

TEST(ConfigErrors, RefuseEndlessAliases) {
  std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 10; ++i) {
    const std::string below = "*a" + std::to_string(i - 1);
    bomb += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + below;
    for (int j = 0; j < 9; ++j) bomb += ", " + below;
    bomb += "]\n";
  }
  EXPECT_NE(parse_error(bomb).find("nested too deeply or without end"), std::string::npos);
}

TEST(ConfigErrors, RefuseDeepNesting) {
  for (const char* level : {"[", "{a: ", "- ", "? ", "[a, ", "{? "}) {
    std::string text = "x:\n  ";
    for (int i = 0; i < 100'000; ++i) text += level;
    EXPECT_NE(parse_error(text).find("nested too deeply"), std::string::npos) << level;
  }
}

TEST(ConfigErrors, RefuseWhatYamlCppReadsWithoutEnd) {
  EXPECT_EQ(parse_error(",5"), "f.yaml:1:1: a \",\" is not expected here; a text with it needs quotes");
  EXPECT_EQ(parse_error("\"t\",\"x\"\n1,2\n"), "f.yaml:1:4: a \",\" is not expected here; a text with it needs quotes");
  EXPECT_EQ(parse_error("\xEF\xBB\xBF,a\n"), "f.yaml:1:1: a \",\" is not expected here; a text with it needs quotes");
  EXPECT_EQ(parse_error("a: 5", {"a=,5"}), "--set a=,5: a \",\" is not expected here; a text with it needs quotes");
}

/// Parses all texts of up to three of YAML's tokens in little memory and time, and ends the process.
[[noreturn]] void parse_all_beginnings() {
  const rlimit memory{rlim_t{1} << 30, rlim_t{1} << 30};
  if (!kAddressSanitizer) setrlimit(RLIMIT_AS, &memory);
  const rlimit seconds{120, 120};
  setrlimit(RLIMIT_CPU, &seconds);
  const std::vector<std::string> tokens = {",",   "[",   "]",  "{", "}", "- ", "? ",  ": ",  "a",  "\"b\" ", "&c ",
                                           "*c ", "!d ", "!!", "%", "|", ">",  "---", "...", "\n", " ",      "#"};
  const std::size_t base = tokens.size() + 1;
  for (std::size_t i = 0; i < base * base * base; ++i) {
    std::string text;
    for (std::size_t left = i; left > 0; left /= base) {
      if (left % base > 0) text += tokens[left % base - 1];
    }
    parse_error(text);
  }
  std::_Exit(0);
}

TEST(ConfigErrors, RefuseKeysThatNoYamlHasRoomFor) {
  const std::string longest(200, 'k');
  EXPECT_EQ(parse_error(longest + ": 1"), "no error");
  EXPECT_NE(parse_error("{ " + longest + "k: 1 }").find("f.yaml:1:3: a key of 201 bytes begins with \"kkk"),
            std::string::npos);
  EXPECT_EQ(parse_error("{}", {longest + "=1"}), "no error");
  EXPECT_NE(parse_error("{}", {longest + "k=1"}).find("a part of the key has more than 200 bytes"), std::string::npos);
}

TEST(ConfigErrors, EndForEveryBeginning) { EXPECT_EXIT(parse_all_beginnings(), testing::ExitedWithCode(0), ""); }

TEST(ConfigErrors, RefuseFilesThatAreTooLong) {
  const test::TemporaryFolder folder;
  const std::string file = folder / "log.yaml";
  std::ofstream(file) << "a: 1\n" << std::string(std::size_t{1} << 26, '#');
  EXPECT_EQ(message_of([&] { Config::load(file); }), file + ": is longer than 64 MiB, a YAML file is expected");
}

TEST(ConfigErrors, ExplainAnUnsetEnvironmentVariable) {
  unsetenv("WAYMARK_TEST_UNSET");
  const std::string unset = parse_error("a:\n  b: x/${WAYMARK_TEST_UNSET}\n");
  EXPECT_EQ(
      unset.rfind("f.yaml:2:6: ${WAYMARK_TEST_UNSET}: the environment variable WAYMARK_TEST_UNSET is not set; ", 0), 0u)
      << unset;
  setenv("WAYMARK_TEST_UNSET", "", 1);
  EXPECT_EQ(parse_error("a:\n  b: x/${WAYMARK_TEST_UNSET}\n"), unset);
  unsetenv("WAYMARK_TEST_UNSET");
}

TEST(ConfigErrors, AreOneLineOfBoundedLength) {
  const auto number_error = [](const std::string& value) {
    return message_of([&] { Config::parse("a: " + value, "f.yaml").number("a"); });
  };
  EXPECT_EQ(number_error("|\n  x\n  y\n"), "f.yaml:1:4: a: \"x\\ny\\n\" is not a number");
  EXPECT_EQ(number_error("\"x\\ry\""), "f.yaml:1:4: a: \"x\\ry\" is not a number");
  const std::string longest = number_error(std::string(100000, 'x'));
  EXPECT_LT(longest.size(), 2010u);
  EXPECT_TRUE(longest.ends_with("x…")) << longest;
  EXPECT_EQ(message_of([&] { Config::parse("{ \"b\\nc\": 1 }", "f.yaml").reject_unread(); }).find('\n'),
            std::string::npos);
}

TEST(ConfigErrors, RefuseNumbersThatCannotBeComputedWith) {
  for (const std::string number : {"1e51", "-1e51", "1e-51", "-1e-300", "1e-310"}) {
    EXPECT_EQ(read_error("x: " + number, [](const Config& c) { c.number("x"); }),
              "f.yaml:3:8: sensors.gps.x: " + number +
                  " is too large or too small to compute with; 0 or 1e-50 to 1e50 is expected");
  }
  for (const char* number : {"0", "1e50", "-1e50", "1e-50"})
    EXPECT_EQ(Config::parse("a: " + std::string(number)).number("a"), std::strtod(number, nullptr));
}

TEST(ConfigErrors, ExplainWrongVariables) {
  EXPECT_EQ(parse_error("variables: { log: x }\na: ${lgo}"),
            "f.yaml:2:4: ${lgo}: variables: has no such name; did you mean \"log\"?");
  EXPECT_EQ(parse_error("variables:\n  a: ${b}\n  b: ${a}\nc: ${a}\n"),
            "f.yaml:3:6: ${a}: the variable refers to itself");
  // also where nothing uses them
  EXPECT_EQ(parse_error("variables:\n  a: ${b}\n  b: ${a}\nc: 1\n"), "f.yaml:3:6: ${a}: the variable refers to itself");
  EXPECT_EQ(parse_error("variables: { l: [1, { x: \"y${l}\" }] }\nc: 1\n"),
            "f.yaml:1:26: ${l}: the variable refers to itself");
  EXPECT_EQ(parse_error("variables: { l: [1] }\na: x${l}"),
            "f.yaml:2:4: ${l}: is a list and cannot stand inside a text");
  EXPECT_EQ(parse_error("a: x${b"), "f.yaml:1:4: \"x${b\": a ${ has no }");
  EXPECT_EQ(parse_error("variables: 5\n"), "f.yaml:1:12: variables: 5 is not a mapping of names to values");
}

/// `name: "${above}${above}…"` for a number of levels, each made of the one before.
std::string levels(int count, const std::string& line, const std::string& first) {
  std::string text = "variables:\n  v0: " + first + "\n";
  for (int i = 1; i <= count; ++i) {
    std::string one = line;
    for (auto at = one.find('@'); at != std::string::npos; at = one.find('@'))
      one.replace(at, 1, "${v" + std::to_string(i - 1) + "}");
    text += "  v" + std::to_string(i) + ": " + one + "\n";
  }
  return text + "a: ${v" + std::to_string(count) + "}\n";
}

TEST(ConfigErrors, BoundWhatVariablesExpandTo) {
  const std::string longer = parse_error(levels(9, "\"@@@@@@@@@@\"", "0123456789"));
  EXPECT_EQ(longer, "f.yaml:8:7: ${v5}: the text becomes longer than 1 MiB");
  const std::string more = parse_error(levels(9, "[\"@\", \"@\", \"@\", \"@\", \"@\", \"@\", \"@\", \"@\"]", "x"));
  EXPECT_NE(more.find("}: the variables of this file hold more than 200000 values"), std::string::npos) << more;
  const std::string chain = parse_error(levels(10'000, "@", "x"));
  EXPECT_EQ(chain.rfind("f.yaml:9939:10: ${v9936}: variables refer to one another over more than 64 levels", 0), 0u)
      << chain;
  const std::string deep = parse_error(levels(40, "[[\"@\"]]", "x"));
  EXPECT_NE(deep.find("}: nested too deeply: at most 64 levels are expected"), std::string::npos) << deep;
  std::string wide = levels(0, "", std::string(1000 * 1000, 'x'));
  for (int i = 0; i < 20; ++i) wide += "b" + std::to_string(i) + ": ${v0}\n";
  EXPECT_EQ(parse_error(wide), "f.yaml:19:6: ${v0}: the variables of this file expand to more than 16 MiB");
}

TEST(ConfigErrors, ExplainWrongOverrides) {
  std::string deep = "a";
  for (int i = 0; i < 64; ++i) deep += ".a";
  EXPECT_EQ(parse_error("", {deep + "=1"}), "--set " + deep + "=1: the key has more than 64 parts");
  EXPECT_EQ(parse_error("variables: { log: x }\n", {"variables.lgo=y"}),
            "--set variables.lgo=y: there is no variable \"lgo\"; did you mean \"log\"?");
  EXPECT_EQ(parse_error("sensors: [{name: gps}, {plugin: imu}, {x: 1}]", {"sensors.lidar.x=1"}),
            "--set sensors.lidar.x=1: sensors has no element \"lidar\"; there are: gps, imu, 2");
  EXPECT_EQ(parse_error("a: 5", {"a.b=1"}), "--set a.b=1: a is 5, not a mapping or a list");
  EXPECT_EQ(parse_error("a: 5", {"a"}), "--set a: key=value is expected");
  EXPECT_EQ(parse_error("a: 5", {"a..b=1"}), "--set a..b=1: the key has an empty part");
  EXPECT_EQ(parse_error("a: 5", {"a=[1"}).rfind("--set a=[1: ", 0), 0u);
}

TEST(ConfigErrors, NameTheOverrideAsThePlace) {
  EXPECT_EQ(message_of([] { Config::parse("a: 5", "f.yaml", {"a=x"}).number("a"); }),
            "--set a=x: a: \"x\" is not a number");
  EXPECT_EQ(message_of([] {
              const Config config = Config::parse("filter: {}", "f.yaml", {"filter.particels=5"});
              config.child("filter").integer("particles", 1);
              config.reject_unread();
            }),
            "--set filter.particels=5: filter.particels: unknown key; did you mean \"particles\"?");
}

TEST(ConfigErrors, SayWhyAFileCannotBeRead) {
  const test::TemporaryFolder folder;
  EXPECT_NE(message_of([&] { Config::load(folder); }).find("is a folder"), std::string::npos);
  const std::string missing = message_of([&] { Config::load(folder / "none.yaml"); });
  EXPECT_EQ(missing, (folder / "none.yaml").string() + ": cannot be read: No such file or directory");
}

}  // namespace
}  // namespace waymark
