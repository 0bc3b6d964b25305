// SPDX-License-Identifier: Apache-2.0
#include "waymark/io/archive.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <optional>
#include <sstream>
#include <streambuf>
#include <string>
#include <vector>

#include "waymark/base/error.hpp"

namespace waymark {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

enum class Colour : std::uint8_t { red, green };
constexpr Colour last_of(Colour /*colour*/) { return Colour::green; }

TEST(Archive, GivesBackWhatWasWritten) {
  std::stringstream stream;
  OutArchive out(stream);
  const Eigen::Matrix3d fixed = Eigen::Matrix3d::Random();
  const Eigen::VectorXd dynamic = Eigen::VectorXd::Random(5);
  out.value(-1.5);
  out.value(std::int64_t{-7});
  out.value(Colour::green);
  out.value(std::string_view("a\0b", 3));
  out.value(fixed);
  out.value(dynamic);
  out.values(std::vector<float>{1.0f, 2.5f});

  InArchive in(stream);
  double number = 0.0;
  std::int64_t integer = 0;
  Colour colour{};
  std::string text;
  Eigen::Matrix3d fixed_back;
  Eigen::VectorXd dynamic_back;
  std::vector<float> values;
  in.value(number);
  in.value(integer);
  in.value(colour);
  in.value(text);
  in.value(fixed_back);
  in.value(dynamic_back);
  in.values(values);
  EXPECT_EQ(number, -1.5);
  EXPECT_EQ(integer, -7);
  EXPECT_EQ(colour, Colour::green);
  EXPECT_EQ(text, std::string("a\0b", 3));
  EXPECT_EQ(fixed_back, fixed);
  EXPECT_EQ(dynamic_back, dynamic);
  EXPECT_EQ(values, (std::vector<float>{1.0f, 2.5f}));
}

std::string section(std::string_view name, std::uint32_t version) {
  std::stringstream stream;
  OutArchive(stream).section(name, version);
  return stream.str();
}

std::uint32_t read_section(const std::string& bytes, std::string_view name, std::uint32_t newest) {
  std::istringstream stream(bytes);
  return InArchive(stream).section(name, newest);
}

TEST(Archive, SectionReturnsItsVersion) { EXPECT_EQ(read_section(section("ekf", 2), "ekf", 3), 2u); }

TEST(Archive, SectionRefusesAnotherName) {
  EXPECT_THAT([] { read_section(section("ekf", 1), "map", 1); },
              ThrowsMessage<DataError>(AllOf(HasSubstr("\"map\""), HasSubstr("\"ekf\""))));
}

TEST(Archive, SectionRefusesANewerVersion) {
  EXPECT_THAT([] { read_section(section("ekf", 5), "ekf", 4); },
              ThrowsMessage<DataError>(AllOf(HasSubstr("version 5"), HasSubstr("4"))));
}

TEST(Archive, SectionRefusesOtherBytes) { EXPECT_THROW(read_section(std::string(64, 'x'), "ekf", 1), DataError); }

TEST(Archive, RefusesEveryTruncation) {
  const std::string whole = section("ekf", 1);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_THROW(read_section(whole.substr(0, size), "ekf", 1), DataError) << size;
  }
}

TEST(Archive, RefusesALengthBeyondTheEndWithoutTakingTheMemory) {
  std::stringstream stream;
  OutArchive out(stream);
  out.value(std::uint64_t{1} << 33);
  InArchive in(stream);
  std::string text;
  EXPECT_THROW(in.value(text), DataError);
  EXPECT_LT(text.capacity(), 1024u);
}

TEST(Archive, RefusesALengthThatOverflows) {
  std::stringstream stream;
  OutArchive(stream).value(~std::uint64_t{0});
  InArchive in(stream);
  std::vector<double> values;
  EXPECT_THROW(in.values(values), DataError);
}

TEST(Archive, RefusesAMatrixOfAnotherShape) {
  std::stringstream stream;
  OutArchive(stream).value(Eigen::Vector2d(1.0, 2.0));
  InArchive in(stream);
  Eigen::Vector3d back;
  EXPECT_THROW(in.value(back), DataError);
}

// --- damaged values --------------------------------------------------------------------------------------------------

template <class Written, class Read>
std::string error_of(const Written& written, Read back) {
  std::stringstream stream;
  OutArchive(stream).value(written);
  InArchive in(stream);
  try {
    in(back);
  } catch (const DataError& error) {
    return error.what();
  }
  return "";
}

TEST(Archive, RefusesATruthValueThatIsNeither0Nor1) {
  EXPECT_EQ(error_of(std::uint8_t{1}, false), "");
  EXPECT_EQ(error_of(std::uint8_t{2}, false), "checkpoint: a truth value is neither 0 nor 1");
  EXPECT_EQ(error_of(std::uint8_t{255}, false), "checkpoint: a truth value is neither 0 nor 1");
}

TEST(Archive, RefusesAnEnumWithoutSuchAValue) {
  EXPECT_EQ(error_of(std::uint8_t{1}, Colour::red), "");
  EXPECT_EQ(error_of(std::uint8_t{2}, Colour::red), "checkpoint: an enum has no such value");
}

TEST(Archive, RefusesNumbersThatAreNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(error_of(nan, 0.0), "checkpoint: a number is not finite");
  EXPECT_EQ(error_of(std::numeric_limits<float>::infinity(), 0.0f), "checkpoint: a number is not finite");
  EXPECT_EQ(error_of(Eigen::Vector2d(0.0, nan), Eigen::Vector2d{}), "checkpoint: a matrix is not finite");
  std::stringstream stream;
  OutArchive out(stream);
  out(std::vector<double>{1.0, nan});
  InArchive in(stream);
  std::vector<double> values;
  EXPECT_THROW(in(values), DataError);
}

TEST(Archive, RefusesATimeWhoseDifferencesWouldOverflow) {
  EXPECT_EQ(error_of(std::int64_t{1} << 62, Time{}), "");
  EXPECT_EQ(error_of((std::int64_t{1} << 62) + 1, Time{}), "checkpoint: a time lies outside of the range of stamps");
  EXPECT_EQ(error_of(std::numeric_limits<std::int64_t>::min(), Duration{}),
            "checkpoint: a time lies outside of the range of stamps");
}

TEST(Archive, RefusesARotationThatHasNotLength1) {
  EXPECT_EQ(error_of(Eigen::Vector4d(0.0, 0.6, 0.0, 0.8), Eigen::Quaterniond{}), "");
  EXPECT_EQ(error_of(Eigen::Vector4d(0.0, 0.0, 0.0, 0.0), Eigen::Quaterniond{}),
            "checkpoint: a rotation has not length 1");
}

TEST(Archive, RefusesANumberOutsideOfItsRange) {
  for (const int number : {-1, 0, 3, 4}) {
    std::stringstream stream;
    OutArchive(stream).within(number, 0, 3);
    InArchive in(stream);
    int back = 7;
    if (number >= 0 && number <= 3) {
      in.within(back, 0, 3);
      EXPECT_EQ(back, number);
    } else {
      EXPECT_THROW(in.within(back, 0, 3), DataError) << number;
    }
  }
}

/// A stream that cannot say how long it is, as a pipe.
class Pipe : public std::streambuf {
 public:
  explicit Pipe(std::string bytes) : bytes_(std::move(bytes)) {
    setg(bytes_.data(), bytes_.data(), bytes_.data() + bytes_.size());
  }

 private:
  std::string bytes_;
};

TEST(Archive, OfUnknownLengthRefusesALengthBeyondTheEndWithoutTakingTheMemory) {
  std::ostringstream bytes;
  OutArchive(bytes).value(std::uint64_t{1} << 40);
  Pipe pipe(bytes.str());
  std::istream stream(&pipe);
  InArchive in(stream);
  std::vector<double> values;
  EXPECT_THROW(in.values(values), DataError);
  EXPECT_LT(values.capacity(), 100'000u);
}

TEST(Archive, RefusesAMatrixLargerThanTheStream) {
  std::stringstream stream;
  OutArchive out(stream);
  out.value(std::int32_t{1} << 20);
  out.value(std::int32_t{1} << 20);
  InArchive in(stream);
  Eigen::MatrixXd matrix;
  EXPECT_THROW(in.value(matrix), DataError);
}

// --- shared objects --------------------------------------------------------------------------------------------------

TEST(Archive, RefusesASharedObjectOfAnotherType) {
  std::stringstream stream;
  OutArchive out(stream);
  for (const std::uint64_t number : {0U, 0U}) out.value(number);
  InArchive in(stream);
  std::uint64_t number = 0;
  ASSERT_EQ(in.shared<double>(number), nullptr);
  in.remember(number, std::make_shared<double>(1.0));
  EXPECT_THROW(in.shared<float>(number), DataError);
}

TEST(Archive, RefusesASharedObjectThatIsAPartOfItself) {
  std::stringstream stream;
  OutArchive out(stream);
  for (const std::uint64_t number : {0U, 0U}) out.value(number);
  InArchive in(stream);
  std::uint64_t number = 0;
  ASSERT_EQ(in.shared<double>(number), nullptr);
  EXPECT_THROW(in.shared<double>(number), DataError);
}

TEST(Archive, RefusesASharedObjectThatComesOutOfOrder) {
  std::stringstream stream;
  OutArchive(stream).value(std::uint64_t{1});
  InArchive in(stream);
  std::uint64_t number = 0;
  EXPECT_THROW(in.shared<double>(number), DataError);
}

TEST(Archive, SharedObjectsAreSharedAgain) {
  std::stringstream stream;
  OutArchive out(stream);
  const auto a = std::make_shared<double>(1.0);
  const auto b = std::make_shared<double>(2.0);
  for (const auto& object : {a, b, a}) {
    if (out.first_sight(object.get())) out.value(*object);
  }

  InArchive in(stream);
  std::vector<std::shared_ptr<double>> loaded;
  for (int i = 0; i < 3; ++i) {
    std::uint64_t number = 0;
    auto object = in.shared<double>(number);
    if (object == nullptr) {
      object = std::make_shared<double>();
      in.value(*object);
      in.remember(number, object);
    }
    loaded.push_back(object);
  }
  EXPECT_EQ(loaded[0], loaded[2]);
  EXPECT_NE(loaded[0], loaded[1]);
  EXPECT_EQ(*loaded[0], 1.0);
  EXPECT_EQ(*loaded[1], 2.0);
}

struct Leg {
  double length_m = 0.0;
  std::string name;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(length_m, name);
  }
  bool operator==(const Leg&) const = default;
};

class Walk {
 public:
  Walk() = default;
  explicit Walk(double length_m)
      : legs_{{length_m, "first"}, {2.0 * length_m, "second"}}, start_(Duration{17}), pause_(5), shortest_(legs_[0]) {
    turns_ = {1.0, -2.0, 3.0};
    place_ << 4.0, 5.0;
    bounded_ = Eigen::Vector2d(6.0, 7.0);
    attitude_ = Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5);
    steps_ = {8, 9};
  }

  template <class Archive>
  void serialize(Archive& archive) {
    const std::uint32_t version = archive.section("walk", 3);
    if constexpr (Archive::kReads) version_read_ = version;
    archive(legs_, start_, pause_, shortest_, longest_, turns_, place_, bounded_, attitude_, steps_, ended_);
  }
  bool operator==(const Walk& other) const {
    return legs_ == other.legs_ && start_ == other.start_ && pause_ == other.pause_ && shortest_ == other.shortest_ &&
           longest_ == other.longest_ && turns_ == other.turns_ && place_ == other.place_ &&
           bounded_ == other.bounded_ && attitude_.coeffs() == other.attitude_.coeffs() && steps_ == other.steps_ &&
           ended_ == other.ended_;
  }
  std::uint32_t version_read() const { return version_read_; }

 private:
  std::vector<Leg> legs_;
  std::optional<Time> start_;
  Duration pause_{};
  std::optional<Leg> shortest_;
  std::optional<Leg> longest_;
  std::array<double, 3> turns_{};
  Eigen::Vector2d place_ = Eigen::Vector2d::Zero();
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1> bounded_;
  Eigen::Quaterniond attitude_ = Eigen::Quaterniond::Identity();
  std::vector<int> steps_;
  bool ended_ = false;
  std::uint32_t version_read_ = 0;
};

std::string written(const Walk& walk) {
  std::stringstream stream;
  OutArchive out(stream);
  out(walk);
  return stream.str();
}

TEST(Archive, OneListOfFieldsServesBothDirections) {
  const Walk walk(1.5);
  const std::string bytes = written(walk);
  Walk back(9.0);  // what it held must give way
  std::istringstream stream(bytes);
  InArchive in(stream);
  in(back);
  EXPECT_EQ(back, walk);
  EXPECT_EQ(back.version_read(), 3u);
  EXPECT_EQ(written(back), bytes);
  EXPECT_EQ(stream.peek(), std::istringstream::traits_type::eof());
}

TEST(Archive, OneListOfFieldsRefusesEveryTruncation) {
  const std::string whole = written(Walk(1.5));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    std::istringstream stream(whole.substr(0, size));
    InArchive in(stream);
    Walk back;
    EXPECT_THROW(in(back), DataError) << size;
  }
}

/// The fields of a list are the same bytes as the values one by one: older checkpoints stay readable.
TEST(Archive, FieldsAreTheBytesOfTheirValues) {
  std::stringstream by_value;
  OutArchive values(by_value);
  const std::optional<Time> stamp(Time(Duration{3}));
  const std::vector<float> ranges{1.0f, 2.0f};
  values.value(1.5);
  values.value(stamp);
  values.value(Eigen::Vector3d(1.0, 2.0, 3.0));
  values.value(std::string_view("text"));
  values.values(ranges);

  std::stringstream by_field;
  OutArchive fields(by_field);
  fields(1.5, stamp, Eigen::Vector3d(1.0, 2.0, 3.0), std::string("text"), ranges);
  EXPECT_EQ(by_field.str(), by_value.str());
}

TEST(Archive, ReportsAStreamThatCannotBeWritten) {
  std::stringstream stream;
  stream.setstate(std::ios::badbit);
  OutArchive out(stream);
  EXPECT_THROW(out.value(1.0), Error);
}

}  // namespace
}  // namespace waymark
