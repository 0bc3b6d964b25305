// SPDX-License-Identifier: Apache-2.0
// The source json as a log, and what it refuses in the YAML.
#include <fstream>
#include <vector>

#include "json_fixture.hpp"

namespace waymark::json_test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class JsonLog : public Json {
 protected:
  std::vector<Measurement> read(const std::string& text, const std::string& more = "") {
    std::ofstream(folder_ / "log.jsonl", std::ios::binary) << text;
    const auto source = make("from: file\nfile: log.jsonl\n" + more);
    EXPECT_FALSE(source->is_live());
    std::vector<Measurement> all;
    bad_.clear();
    while (auto m = source->next()) all.push_back(std::move(*m));
    for (const BadRecord& record : source->bad_records()) bad_.push_back(record.place + ": " + record.reason);
    return all;
  }
  std::string error_of(const std::string& yaml) const {
    try {
      make(yaml);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  }
  std::vector<std::string> bad_;
};

TEST_F(JsonLog, LinesComeInOrderAndArrivalNeverGoesBack) {
  const auto all =
      read(wheels(1, ",\"stamp\":10.5") + "\n" +
           "{\"sensor\":\"gps\",\"stamp_ns\":9000000000,\"east_m\":1,\"north_m\":2}\r\n" + wheels(3, ",\"stamp\":11"));
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[0].stamp, Time(std::chrono::milliseconds(10'500)));
  EXPECT_EQ(all[1].stamp, Time(std::chrono::seconds(9)));
  EXPECT_EQ(all[1].arrival, all[0].stamp);
  EXPECT_EQ(all[1].sensor, 1U);
  EXPECT_EQ(all[1].as<GnssFix>().p_map_antenna.y(), 2.0);
  EXPECT_EQ(all[2].arrival, all[2].stamp);
  EXPECT_EQ(all[2].sequence, 2U);
  EXPECT_EQ(all[2].as<WheelSpeeds>().left_mps, 3.0);
}

TEST_F(JsonLog, BadLinesAreSkippedUpToALimit) {
  const std::string text = wheels(1, ",\"stamp\":1") + "rubbish\n" + wheels(2) + "{\"sensor\":\"whels\"}\n" +
                           wheels(3, ",\"stamp\":4000") + wheels(4, ",\"stamp\":2");
  EXPECT_EQ(read(text, "max_bad_records: 4").size(), 2U);
  const std::string file = (folder_ / "log.jsonl").string();
  EXPECT_THAT(
      bad_,
      ElementsAre(HasSubstr(file + ":2: no JSON at byte 1"), file + ":3: a message in a file needs a stamp or stamp_ns",
                  file + ":4: sensor \"whels\" is not under channels; did you mean \"wheels\"?",
                  file + ":5: time jumps forward from 1.000000000 to 4000.000000000; a step of at most 3600.000 s "
                         "is expected"));
  try {
    read(text, "max_bad_records: 3");
    ADD_FAILURE() << "no error";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("log.jsonl:5:"), HasSubstr("max_bad_records")));
  }
}

TEST_F(JsonLog, TimesAtTheEndsOfTheirRangeAreJumps) {
  const std::string first = wheels(1, ",\"stamp_ns\":-4611686018427387903");
  EXPECT_EQ(read(first + wheels(2, ",\"stamp_ns\":4611686018427387903"), "max_bad_records: 1").size(), 1U);
}

TEST_F(JsonLog, AHugeLineIsOneBadRecord) {
  const std::string huge = "{\"sensor\":\"" + std::string(3 << 20, 'x') + "\"}\n";
  EXPECT_EQ(read(huge + wheels(1, ",\"stamp\":1"), "max_bad_records: 1").size(), 1U);
  EXPECT_THAT(bad_, ElementsAre(HasSubstr(":1: the line is longer than 1048576 bytes")));
}

TEST_F(JsonLog, TheYamlIsChecked) {
  EXPECT_THAT(error_of("from: pipe"), AllOf(HasSubstr("from"), HasSubstr("udp, tcp, unix, stdin, file")));
  EXPECT_THAT(error_of("from: udp"), HasSubstr("port"));
  EXPECT_THAT(error_of("from: udp\nport: 70000"), HasSubstr("70000 is not in [1, 65535]"));
  EXPECT_THAT(error_of("from: tcp\nport: 5005\naddress: here"), HasSubstr("\"here\" is not a numeric address"));
  EXPECT_THAT(error_of("from: file\nfile: nothing.jsonl"), HasSubstr("nothing.jsonl cannot be read"));
  EXPECT_THAT(error_of("from: stdin\nport: 5"), HasSubstr("port"));
  const auto with_channels = [](const std::string& channels) -> std::string {
    try {
      PluginLoader({WAYMARK_PLUGIN_DIR})
          .create<Source>("json", Config::parse("{ from: stdin, channels: " + channels + " }"),
                          Rig({{"wheels", "", std::nullopt}}));
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(with_channels("[]"), HasSubstr("at least one sensor is expected"));
  EXPECT_THAT(with_channels("[{ sensor: wheels, payload: WheelSpeed }]"), HasSubstr("did you mean \"WheelSpeeds\"?"));
  EXPECT_THAT(with_channels("[{ sensor: gps, payload: GnssFix }]"), HasSubstr("there is no sensor \"gps\""));
  EXPECT_THAT(with_channels("[{ sensor: wheels, payload: WheelSpeeds }, { sensor: wheels, payload: BodyTwist }]"),
              HasSubstr("listed twice"));
}

}  // namespace
}  // namespace waymark::json_test
