// SPDX-License-Identifier: Apache-2.0
// Binary files with records of one length, and references that are thinned out.
#include <gmock/gmock.h>

#include <cstring>

#include "unit/plugins/sources/csv/csv_fixture.hpp"

namespace waymark {
namespace {

using csv_test::CsvTest;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

class CsvBinary : public CsvTest {
 protected:
  template <class T>
  static void put(std::string& bytes, T value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes.append(raw, sizeof value);
  }
  /// A header of four bytes, then two records: time, a small number, three ranges in mm.
  static std::string two_scans() {
    std::string bytes = "HEAD";
    for (const double t : {1771363594.5, 1771363594.625}) {
      put(bytes, t);
      put(bytes, std::int8_t{-3});
      for (const int range : {500, 0, 65535}) put(bytes, static_cast<std::uint16_t>(range));
    }
    return bytes;
  }
  static std::string yaml(const std::string& records) {
    return "files: [{ path: scans.bin, sensor: lidar, payload: LaserScan, records: " + records +
           ", time: 0, columns: { ranges_m: { first: 2, count: 3, scale: 1.0e-3 } }, scan: { start_deg: 0, step_deg: 1 "
           "} }]";
  }
  static constexpr const char* kRecords = "{ skip_bytes: 4, fields: [f8, i1, 3 u2] }";
};

TEST_F(CsvBinary, RecordsAreReadAsRowsPlainAndPacked) {
  for (const bool packed : {false, true}) {
    write("scans.bin", packed ? csv_test::gzip(two_scans()) : two_scans());
    const auto source = make(yaml(kRecords));
    const std::vector<Measurement> all = read_all(*source);
    ASSERT_THAT(all, SizeIs(2));
    EXPECT_EQ(all[0].stamp, Time(std::chrono::milliseconds(1771363594500)));
    EXPECT_EQ(all[1].stamp, Time(std::chrono::milliseconds(1771363594625)));
    EXPECT_THAT(all[1].as<LaserScan>().ranges_m, ElementsAre(0.5F, 0.0F, 65.535F));
    EXPECT_DOUBLE_EQ(source->progress(), 1.0);
  }
}

TEST_F(CsvBinary, AllKindsOfNumbersAreRead) {
  std::string bytes;
  put(bytes, std::int64_t{-5});
  put(bytes, std::uint32_t{4'000'000'000});
  put(bytes, -0.25F);
  put(bytes, std::int16_t{-300});
  put(bytes, std::uint8_t{255});
  write("a.bin", bytes);
  const auto read = [this](const std::string& column) {
    const auto source = make(
        "files: [{ path: a.bin, sensor: wheels, payload: BodyTwist, records: { fields: [i8, u4, f4, i2, u1] }, "
        "time: 0, columns: { v_x_mps: " +
        column + ", w_z_radps: 2 } }]");
    return source->next()->as<BodyTwist>().v_x_mps;
  };
  EXPECT_EQ(read("1"), 4e9);
  EXPECT_EQ(read("2"), -0.25);
  EXPECT_EQ(read("3"), -300.0);
  EXPECT_EQ(read("4"), 255.0);
}

TEST_F(CsvBinary, AFileThatEndsWithinARecordIsAnErrorAfterTheRecordsBefore) {
  const std::string whole = two_scans();
  write("scans.bin", std::string_view(whole).substr(0, whole.size() - 1));
  const auto source = make(yaml(kRecords));
  std::vector<Measurement> good;
  EXPECT_THAT(reading_error(*source, &good), HasSubstr("scans.bin:record 2: the file ends after 14 of its 15 bytes"));
  EXPECT_THAT(good, SizeIs(1));
  write("scans.bin", "HE");
  EXPECT_THAT(construction_error<DataError>(yaml(kRecords)), HasSubstr("ends within the 4 bytes before"));
  write("scans.bin", "HEAD");
  EXPECT_THAT(construction_error<DataError>(yaml(kRecords)), HasSubstr("no records"));
}

TEST_F(CsvBinary, ALayoutThatIsNoneIsRefused) {
  write("scans.bin", two_scans());
  const auto error = [this](const std::string& records) { return construction_error<ConfigError>(yaml(records)); };
  EXPECT_THAT(error("{ fields: [f8, f2] }"), HasSubstr("\"f2\" is no field; i1, i2"));
  EXPECT_THAT(error("{ fields: [u8, 0 u2] }"), HasSubstr("\"0 u2\" is no field"));
  EXPECT_THAT(error("{ fields: [8] }"), HasSubstr("\"8\" is no field"));
  EXPECT_THAT(error("{ fields: [3u2] }"), HasSubstr("\"3u2\" is no field"));
  EXPECT_THAT(error("{ fields: [99999999999999999999 u2] }"), HasSubstr("is no field"));
  EXPECT_THAT(error("{ fields: [999999 u1, 2 u1] }"), HasSubstr("more than 1000000 numbers"));
  EXPECT_THAT(error("{ fields: [] }"), HasSubstr("is empty"));
  EXPECT_THAT(error("{ fields: [f8] }, header_rows: 1"), HasSubstr("is of text files; this one has records"));
}

TEST_F(CsvBinary, AReferenceIsThinnedOut) {
  write("a.csv", "0,1,2\n");
  write("truth.csv", "0,1,1\n0.5,2,1\n0.5,3,1\n0.501,4,1\n0.6,5,1\n");
  const auto source = make(csv_test::wheels_yaml("a.csv") +
                           "reference: { trajectory: { path: truth.csv, min_step_s: 0.01, columns: { time: 0, x_m: 1, "
                           "y_m: 2 } } }\n");
  std::vector<double> x;
  for (const auto& point : source->reference()->trajectory) x.push_back(point.T_map_base.p.x());
  EXPECT_THAT(x, ElementsAre(1, 2, 5));
}

}  // namespace
}  // namespace waymark
