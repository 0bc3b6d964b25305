// SPDX-License-Identifier: Apache-2.0
// The JSON schema of configurations: it is the committed one, every shipped configuration satisfies it, and it finds
// mistakes.
#include <gmock/gmock.h>
#include <yaml-cpp/yaml.h>

#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/adapters/yaml_cpp_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validation_results.hpp>
#include <valijson/validator.hpp>

#include "tests/system/command.hpp"

namespace waymark::system_test {
namespace {

constexpr const char* kCommitted = WAYMARK_SOURCE_DIR "/config/waymark.schema.json";

/// What is wrong with a YAML, one line each; empty: nothing.
std::string problems(const YAML::Node& yaml) {
  static const valijson::Schema* const schema = [] {
    auto* parsed = new valijson::Schema;
    const auto document = nlohmann::json::parse(read_text(kCommitted));
    const valijson::adapters::NlohmannJsonAdapter adapter(document);
    valijson::SchemaParser(valijson::SchemaParser::kDraft7).populateSchema(adapter, *parsed);
    return parsed;
  }();
  valijson::Validator validator(valijson::Validator::kWeakTypes);  // a YAML's scalars are texts
  valijson::ValidationResults results;
  const valijson::adapters::YamlCppAdapter adapter(yaml);
  if (validator.validate(*schema, adapter, &results)) return {};
  std::string text;
  for (valijson::ValidationResults::Error error; results.popError(error);) {
    for (const std::string& step : error.context) text += step;
    text += ": " + error.description + '\n';
  }
  return text.empty() ? "not valid" : text;
}

TEST(Schema, IsTheCommittedOne) {
  const Outcome outcome = waymark({"schema"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(outcome.out == read_text(kCommitted))
      << "the schema is old; waymark schema > config/waymark.schema.json writes it";
}

TEST(Schema, EveryShippedConfigurationNamesItAndSatisfiesIt) {
  int configurations = 0;
  for (const auto& entry : std::filesystem::directory_iterator(WAYMARK_SOURCE_DIR "/config")) {
    if (entry.path().extension() != ".yaml") continue;
    ++configurations;
    EXPECT_TRUE(read_text(entry.path()).starts_with("# yaml-language-server: $schema=waymark.schema.json\n"))
        << entry.path();
    EXPECT_EQ(problems(YAML::LoadFile(entry.path().string())), "") << entry.path();
  }
  EXPECT_GT(configurations, 20);
}

class Mistake : public testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(Mistake, IsFound) {
  std::string yaml = read_text(WAYMARK_SOURCE_DIR "/config/quickstart.yaml");
  ASSERT_EQ(problems(YAML::Load(yaml)), "");
  const std::string right = GetParam().first;
  const std::size_t at = yaml.find(right);
  ASSERT_NE(at, std::string::npos) << right;
  yaml.replace(at, right.size(), GetParam().second);
  EXPECT_NE(problems(YAML::Load(yaml)), "");
}

INSTANTIATE_TEST_SUITE_P(Schema, Mistake,
                         testing::Values(std::pair("\nsensors:", "\nsensor:"),
                                         std::pair("plugin: odometry", "plugin: odometri"),
                                         std::pair("kind: planar", "kind: plane"), std::pair("track_m:", "trak_m:"),
                                         std::pair("particles: 25", "partcles: 25"),
                                         std::pair("plugin: tum", "plugin: tum, trajectori: a.txt")));

}  // namespace
}  // namespace waymark::system_test
