// SPDX-License-Identifier: Apache-2.0
#include "waymark/interface/payload_registry.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <sstream>
#include <string>

#include "fusion/measurement_archive.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

struct Depth : PayloadOf<Depth> {
  static constexpr std::string_view kType = "boat/Depth@1";
  double depth_m = 2.5;
  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&Depth::depth_m, {.names = {"depth_m"}, .unit = "m", .meaning = "below the surface"});
  }
};

/// Another author's payload of the same name.
struct DepthInFeet : PayloadOf<DepthInFeet> {
  static constexpr std::string_view kType = Depth::kType;
  double depth_ft = 0.0;
  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&DepthInFeet::depth_ft, {.names = {"depth_ft"}, .unit = "ft", .meaning = "below the surface"});
  }
};

/// A short name that core has, too.
struct Height : PayloadOf<Height> {
  static constexpr std::string_view kType = "boat/Height@1";
  double mast_m = 0.0;
  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&Height::mast_m, {.names = {"mast_m"}, .unit = "m", .meaning = "of the mast"});
  }
};

template <class Call>
std::string error_of(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(PayloadRegistry, ARegisteredPayloadIsMadeByItsName) {
  register_payload<Depth>();
  const auto made = make_payload("boat/Depth@1");
  ASSERT_NE(made, nullptr);
  EXPECT_EQ(made->type(), Depth::kType);
  EXPECT_EQ(static_cast<const Depth&>(*made).depth_m, 2.5);
  EXPECT_EQ(make_payload("boat/Depth@2"), nullptr);
}

TEST(PayloadRegistry, AYamlMayNameItByItsShortName) {
  register_payload<Depth>();
  register_payload<Height>();
  EXPECT_EQ(find_payload_type("Depth"), Depth::kType);
  EXPECT_EQ(find_payload_type("boat/Depth@1"), Depth::kType);
  EXPECT_EQ(find_payload_type("Height"), waymark::Height::kType) << "a short name of core is core's";
  EXPECT_EQ(find_payload_type("boat/Height@1"), Height::kType);
  EXPECT_EQ(find_payload_type("Deepness"), "");
  EXPECT_EQ(find_payload_type(""), "");
}

TEST(PayloadRegistry, AllPayloadsAreKnownOnceWithTheirFields) {
  register_payload<Depth>();
  register_payload<Depth>();
  std::size_t depths = 0;
  for (const KnownPayload& known : known_payloads()) {
    EXPECT_EQ(known.make()->type(), known.type);
    EXPECT_FALSE(known.describe().empty());
    if (known.type != Depth::kType) continue;
    ++depths;
    EXPECT_EQ(known.describe().front().name, "depth_m");
    EXPECT_FALSE(is_of_core(known.type));
  }
  EXPECT_EQ(depths, 1U);
  EXPECT_TRUE(is_of_core(LaserScan::kType));
}

TEST(PayloadRegistry, OneNameForTwoLayoutsIsRefused) {
  register_payload<Depth>();
  EXPECT_THAT(error_of([] { register_payload<DepthInFeet>(); }),
              AllOf(HasSubstr("boat/Depth@1"), HasSubstr("depth_m"), HasSubstr("depth_ft")));
  EXPECT_EQ(static_cast<const Depth&>(*make_payload(Depth::kType)).depth_m, 2.5);
}

TEST(PayloadRegistry, NamesOfCoreAndNamesWithoutVersionAreRefused) {
  const auto make = []() -> std::shared_ptr<Payload> { return std::make_shared<Depth>(); };
  for (const char* name : {"Depth", "boat/Depth", "/Depth@1", "boat/@1", "boat/Depth@", "Depth@1"})
    EXPECT_THAT(error_of([&] { register_payload({name, make, &describe_fields<Depth>}); }), HasSubstr(name)) << name;
  EXPECT_THAT(error_of([&] {
                register_payload({LaserScan::kType, make, &describe_fields<Depth>});
              }),
              HasSubstr("payload of core"));
}

TEST(PayloadRegistry, ACheckpointKeepsAMeasurementOfARegisteredPayload) {
  register_payload<Depth>();
  auto depth = std::make_shared<Depth>();
  depth->depth_m = 7.25;
  Measurement measurement;
  measurement.stamp = measurement.arrival = Time(std::chrono::seconds(3));
  measurement.payload = depth;
  std::stringstream stream;
  OutArchive out(stream);
  fusion::write_measurement(out, measurement);
  InArchive in(stream);
  EXPECT_EQ(fusion::read_measurement(in).as<Depth>().depth_m, 7.25);
}

}  // namespace
}  // namespace waymark
