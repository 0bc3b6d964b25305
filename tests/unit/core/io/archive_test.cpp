// SPDX-License-Identifier: Apache-2.0
#include "waymark/io/archive.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "waymark/base/error.hpp"

namespace waymark {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(Archive, GivesBackWhatWasWritten) {
  enum class Colour : std::uint8_t { red = 3 };
  std::stringstream stream;
  OutArchive out(stream);
  const Eigen::Matrix3d fixed = Eigen::Matrix3d::Random();
  const Eigen::VectorXd dynamic = Eigen::VectorXd::Random(5);
  out.value(-1.5);
  out.value(std::int64_t{-7});
  out.value(Colour::red);
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
  EXPECT_EQ(colour, Colour::red);
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
    auto object = std::static_pointer_cast<double>(in.shared(number));
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

TEST(Archive, ReportsAStreamThatCannotBeWritten) {
  std::stringstream stream;
  stream.setstate(std::ios::badbit);
  OutArchive out(stream);
  EXPECT_THROW(out.value(1.0), Error);
}

}  // namespace
}  // namespace waymark
