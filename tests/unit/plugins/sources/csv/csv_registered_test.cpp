// SPDX-License-Identifier: Apache-2.0
// Payloads that a plugin has registered.
#include <gmock/gmock.h>

#include <array>

#include "unit/plugins/sources/csv/csv_fixture.hpp"
#include "waymark/interface/payload_registry.hpp"

namespace waymark {
namespace {

using csv_test::CsvTest;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::SizeIs;

enum class Weather { dry, wet };

/// A field of each kind that a row can hold.
struct Station : PayloadOf<Station> {
  static constexpr std::string_view kType = "csv_test/Station@1";
  static constexpr std::array<std::string_view, 2> kWords{"dry", "wet"};
  double level_m = 0.0;
  Eigen::Vector3d wind_mps = Eigen::Vector3d::Constant(-1.0);
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  int number = -1;
  bool open = false;
  Weather weather = Weather::dry;
  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&Station::level_m, {.names = {"level_m"}, .unit = "m", .limit = 50.0});
    field(&Station::wind_mps, {.names = {"wind_x_mps", "wind_y_mps", "wind_z_mps"}, .unit = "m/s", .required = false});
    field(&Station::q, {.names = {"q_w", "q_x", "q_y", "q_z"}, .required = false});
    field(&Station::number, {.names = {"number"}, .required = false});
    field(&Station::open, {.names = {"open"}, .required = false});
    field(&Station::weather, {.names = {"weather"}, .required = false, .words = kWords});
  }
  std::string_view contradiction() const { return level_m == 13.0 ? "nobody measures 13 m" : ""; }
};

/// A set, with a field beside it.
struct Echoes : PayloadOf<Echoes> {
  static constexpr std::string_view kType = "csv_test/Echoes@1";
  struct One {
    double range_m = 0.0;
    int beam = -1;
    template <class Visitor>
    static void fields(Visitor&& field) {
      field(&One::range_m, {.names = {"range_m"}, .unit = "m"});
      field(&One::beam, {.names = {"beam"}, .required = false});
    }
  };
  double gain_db = 0.0;
  std::vector<One> echoes;
  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&Echoes::gain_db, {.names = {"gain_db"}, .unit = "dB", .required = false});
    field(&Echoes::echoes, {.names = {"echoes"}});
  }
};

struct Spectrum : PayloadOf<Spectrum> {
  static constexpr std::string_view kType = "csv_test/Spectrum@1";
  std::vector<float> powers;
  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&Spectrum::powers, {.names = {"powers"}});
  }
};

class CsvRegistered : public CsvTest {
 protected:
  CsvRegistered() {
    register_payload<Station>();
    register_payload<Echoes>();
    register_payload<Spectrum>();
  }
  std::string error_of(const std::string& file) const {
    try {
      make("files: [" + file + "]");
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  }
};

TEST_F(CsvRegistered, ARowHoldsAllFields) {
  write("a.csv", "t,level,wx,wy,wz,w,x,y,z,n,open,sky\n1,250,1,2,3,0,0,0,2e0,7,1,5\n2,300,4,5,6,1,0,0,0,8,0,4\n");
  const auto source = make(
      "files: [{ path: a.csv, sensor: other, payload: Station, time: t, columns: { level_cm: level, "
      "wind_x_mps: wx, wind_y_mps: wy, wind_z_mps: wz, number: n, open: open, "
      "weather: { column: sky, map: { 4: dry, 5: wet } } } }]");
  const auto all = read_all(*source);
  ASSERT_THAT(all, SizeIs(2));
  const auto& first = all[0].as<Station>();
  EXPECT_DOUBLE_EQ(first.level_m, 2.5);
  EXPECT_EQ(first.wind_mps, Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_EQ(first.number, 7);
  EXPECT_TRUE(first.open);
  EXPECT_EQ(first.weather, Weather::wet);
  EXPECT_EQ(all[1].as<Station>().weather, Weather::dry);
  EXPECT_FALSE(all[1].as<Station>().open);
}

TEST_F(CsvRegistered, AFieldWithoutAColumnKeepsItsDefault) {
  write("a.csv", "t,level,w,x,y,z\n1,2,0,0,0,1\n");
  const auto source = make(
      "files: [{ path: a.csv, sensor: other, payload: csv_test/Station@1, time: t, columns: { level_m: level, q_w: w, "
      "q_x: x, q_y: y, q_z: z } }]");
  const auto all = read_all(*source);
  ASSERT_THAT(all, SizeIs(1));
  EXPECT_EQ(all[0].as<Station>().number, -1);
  EXPECT_EQ(all[0].as<Station>().wind_mps, Eigen::Vector3d::Constant(-1.0));
  EXPECT_EQ(all[0].as<Station>().q.z(), 1.0);
}

TEST_F(CsvRegistered, RowsOfOneTimeFormASet) {
  write("a.csv", "t,r,b,g\n1,10,0,3\n1,11,1,4\n1,12,2,5\n2,20,0,6\n");
  const auto source = make(
      "files: [{ path: a.csv, sensor: other, payload: Echoes, time: t, group_by_time: true, columns: { range_m: r, "
      "beam: "
      "b, gain_db: g } }]");
  const auto all = read_all(*source);
  ASSERT_THAT(all, SizeIs(2));
  const auto& first = all[0].as<Echoes>();
  ASSERT_THAT(first.echoes, SizeIs(3));
  EXPECT_EQ(first.echoes[0].range_m, 10.0);
  EXPECT_EQ(first.echoes[1].range_m, 11.0);
  EXPECT_EQ(first.echoes[2].range_m, 12.0);
  EXPECT_EQ(first.echoes[2].beam, 2);
  EXPECT_EQ(first.gain_db, 3.0) << "a field beside the list is that of the set's first row";
  EXPECT_THAT(all[1].as<Echoes>().echoes, SizeIs(1));
}

TEST_F(CsvRegistered, ARowWithoutAnElementIsAnEmptySet) {
  write("a.csv", "t,r\n1,\n2,20\n");
  const auto source = make(
      "files: [{ path: a.csv, sensor: other, payload: Echoes, time: t, empty_is_unknown: true, columns: { range_m: r } "
      "}]");
  const auto all = read_all(*source);
  ASSERT_THAT(all, SizeIs(2));
  EXPECT_THAT(all[0].as<Echoes>().echoes, SizeIs(0));
  EXPECT_THAT(all[1].as<Echoes>().echoes, SizeIs(1));
}

TEST_F(CsvRegistered, RulesOfThePayloadMakeBadRows) {
  write("a.csv", "t,level\n1,2\n2,13\n3,51\n4,5\n");
  const auto source = make(
      "max_bad_rows: 2\nfiles: [{ path: a.csv, sensor: other, payload: Station, time: t, columns: { level_m: level } "
      "}]");
  EXPECT_THAT(read_all(*source), SizeIs(2));
  ASSERT_THAT(source->bad_records(), SizeIs(2));
  EXPECT_THAT(source->bad_records()[0].reason, HasSubstr("nobody measures 13 m"));
  EXPECT_THAT(source->bad_records()[1].reason, HasSubstr("51"));
}

TEST_F(CsvRegistered, ErrorsNameWhatThereIs) {
  write("a.csv", "t,level\n1,2\n");
  const std::string file = "{ path: a.csv, sensor: other, time: t, ";
  EXPECT_THAT(error_of(file + "payload: Station, columns: { number: 1 } }"), HasSubstr("level_m"));
  EXPECT_THAT(error_of(file + "payload: Station, columns: { level_m: level, nunber: 1 } }"), HasSubstr("\"number\""));
  EXPECT_THAT(error_of(file + "payload: Station, columns: { level_m: level, wind_x_mps: 1 } }"),
              AllOf(HasSubstr("wind_y_mps"), HasSubstr("or none of them")));
  EXPECT_THAT(error_of(file + "payload: Statoin, columns: { level_m: level } }"), HasSubstr("Station"));
  EXPECT_THAT(error_of(file + "payload: Spectrum, columns: { powers: level } }"),
              HasSubstr("\"powers\", which a row cannot hold"));
  EXPECT_THAT(error_of(file + "payload: Station, group_by_time: true, columns: { level_m: level } }"),
              HasSubstr("form no set"));
}

}  // namespace
}  // namespace waymark
