// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/cdr/payload_cdr.hpp"

#include <gmock/gmock.h>

#include <bit>
#include <limits>

#include "plugins/shared/cdr/definition.hpp"
#include "plugins/shared/cdr/wire_writer.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::ros_test {
namespace {

using ros::Unusable;
using testing::HasSubstr;

/// Gives every field bits of its own: odd ones, NaN among them.
class OddBits final : public FieldEditor {
 public:
  void field(const FieldInfo& info, const FieldSlot& slot) override {
    std::visit([&](const auto& place) { set(info, place); }, slot);
  }
  std::size_t list(const FieldInfo&) override { return 3; }

 private:
  void set(const FieldInfo&, std::span<double> numbers) {
    for (double& number : numbers) number = std::bit_cast<double>(next());
  }
  void set(const FieldInfo&, int* number) { *number = static_cast<int>(next()); }
  void set(const FieldInfo&, bool* truth) { *truth = !*truth; }
  void set(const FieldInfo& info, const WordSlot& word) {
    word.assign(word.value, static_cast<int>(info.words.size()) - 1);
  }
  void set(const FieldInfo&, std::vector<float>* numbers) {
    for (int i = 0; i < 5; ++i) numbers->push_back(std::bit_cast<float>(static_cast<std::uint32_t>(next())));
  }
  void set(const FieldInfo&, std::vector<Eigen::Vector3f>* points) {
    for (int i = 0; i < 5; ++i)
      points->emplace_back(0.1f, std::bit_cast<float>(static_cast<std::uint32_t>(next())), -0.0f);
  }
  void set(const FieldInfo&, std::vector<std::uint8_t>* bytes) {
    for (int i = 0; i < 5; ++i) bytes->push_back(static_cast<std::uint8_t>(next()));
  }
  /// Most are NaN, some signalling.
  std::uint64_t next() { return state_ += 0x0010'0001'0203'0507ULL; }

  std::uint64_t state_ = 0x7fe0'1234'5678'9abcULL;
};

template <class Check>
void for_each_payload(Check check) {
  std::apply([&](const auto&... payload) { (check(payload), ...); }, CorePayloads());
}

TEST(PayloadCdr, EveryCorePayloadIsReadBackToTheBit) {
  for_each_payload([]<class T>(const T&) {
    T payload;
    OddBits bits;
    payload.edit(bits);
    const auto written = ros::payload_to_cdr(payload);
    const auto again = ros::payload_from_cdr(T::kType, written);
    ASSERT_EQ(again->type(), T::kType);
    EXPECT_EQ(ros::payload_to_cdr(*again), written) << T::kType;
    EXPECT_NE(ros::payload_to_cdr(T()), written) << T::kType;
  });
}

TEST(PayloadCdr, NotANumberKeepsItsBits) {
  Height height;
  height.sigma_m = std::bit_cast<double>(0x7ff4'0000'dead'beefULL);
  const auto again = ros::payload_from_cdr(Height::kType, ros::payload_to_cdr(height));
  EXPECT_EQ(std::bit_cast<std::uint64_t>(static_cast<const Height&>(*again).sigma_m), 0x7ff4'0000'dead'beefULL);
}

TEST(PayloadCdr, TheDefinitionReadsWhatIsWritten) {
  for_each_payload([]<class T>(const T&) {
    T payload;
    OddBits bits;
    payload.edit(bits);
    const ros::Definition definition(ros::payload_message_type(T::kType), ros::payload_definition(T::kType));
    EXPECT_NO_THROW(definition.numbers(ros::payload_to_cdr(payload))) << ros::payload_definition(T::kType);
    EXPECT_EQ(ros::payload_definition(payload), ros::payload_definition(T::kType));
  });
}

TEST(PayloadCdr, TheDefinitionHasUnitsAndMeanings) {
  EXPECT_EQ(ros::payload_message_type(LaserScan::kType), "waymark_msgs/msg/LaserScan");
  const std::string scan = ros::payload_definition(LaserScan::kType);
  EXPECT_THAT(scan, HasSubstr("float64 start_rad  # direction of beam 0, rad\n"));
  EXPECT_THAT(scan, HasSubstr("float32[] ranges_m  # "));
  const std::string seen = ros::payload_definition(LandmarkObservations::kType);
  EXPECT_THAT(seen, HasSubstr("waymark_msgs/LandmarkObservationsLandmarks[] landmarks"));
  EXPECT_THAT(seen, HasSubstr("MSG: waymark_msgs/LandmarkObservationsLandmarks\nfloat64 range_m"));
  EXPECT_THAT(ros::payload_definition(GnssFix::kType),
              HasSubstr("int32 type  # kind of the solution; 0 none, 1 single"));
}

TEST(PayloadCdr, WhatIsCutOffIsUnusable) {
  for_each_payload([]<class T>(const T&) {
    T payload;
    OddBits bits;
    payload.edit(bits);
    const auto whole = ros::payload_to_cdr(payload);
    for (std::size_t size = 0; size < whole.size(); ++size)
      EXPECT_THROW(ros::payload_from_cdr(T::kType, ros::Bytes(whole).first(size)), Unusable) << T::kType;
  });
}

TEST(PayloadCdr, AWordThatIsNoneIsUnusable) {
  ros::WireWriter out;
  out.value(std::int32_t{3});
  out.value(std::int32_t{0});
  out.value(std::int32_t{0});
  out.count(0);
  EXPECT_THROW(ros::payload_from_cdr(Image::kType, out.bytes()), Unusable);
}

struct Opaque : PayloadOf<Opaque> {
  static constexpr std::string_view kType = "test/Opaque@1";
};

/// A list, then another field.
struct Tray : PayloadOf<Tray> {
  static constexpr std::string_view kType = "test/Tray@2";
  struct Cup {
    double x = 1.0;
    Eigen::Vector3d p{1.0, 2.0, 3.0};
    template <class Visitor>
    static void fields(Visitor&& field) {
      field(&Cup::x, {.names = {"x"}, .meaning = "size"});
      field(&Cup::p, {.names = {"px", "py", "pz"}, .meaning = "place"});
    }
  };
  std::vector<Cup> cups;
  int count = 4;
  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&Tray::cups, {.names = {"cups"}, .meaning = "all"});
    field(&Tray::count, {.names = {"count"}, .meaning = "number"});
  }
};

TEST(PayloadCdr, PayloadsOfPluginsAreWrittenThroughTheirFields) {
  Tray tray;
  tray.cups.resize(2);
  const std::string text = ros::payload_definition(tray);
  EXPECT_EQ(text, "test_msgs/TrayCups[] cups  # all\nint32 count  # number\n" + std::string(80, '=') +
                      "\nMSG: test_msgs/TrayCups\nfloat64 x  # size\nfloat64 px  # place\nfloat64 py\nfloat64 pz\n");
  const ros::Definition definition(ros::payload_message_type(Tray::kType), text);
  EXPECT_THAT(definition.numbers(ros::payload_to_cdr(tray)), testing::ElementsAre(4.0));
  tray.cups.clear();
  EXPECT_THROW(ros::payload_definition(tray), Unusable);
  EXPECT_THROW(ros::payload_from_cdr(Tray::kType, ros::payload_to_cdr(tray)), Unusable);
}

TEST(PayloadCdr, OpaquePayloadsAreRefused) {
  EXPECT_THROW(ros::payload_to_cdr(Opaque()), Unusable);
  EXPECT_THROW(ros::payload_definition(Opaque()), Unusable);
}

}  // namespace
}  // namespace waymark::ros_test
