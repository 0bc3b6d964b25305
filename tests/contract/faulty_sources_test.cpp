// SPDX-License-Identifier: Apache-2.0
// The kit must find faults: one source that is good, and the same with one fault at a time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "our_plugins.hpp"
#include "waymark/testing/source_contract.hpp"

namespace waymark::contract_test {
namespace {

using ::testing::Contains;
using ::testing::IsEmpty;
using ::testing::StartsWith;

enum class Fault {
  none,
  random,
  endless,
  empty,
  starts_again,
  wrong_type,
  no_such_channel,
  nan_value,
  null_payload,
  stamp_after_arrival,
  arrivals_go_back,
  equal_sequence,
  progress_beyond_one,
  bad_record_without_place,
  reference_goes_back,
  no_channels
};

class Counter final : public Source {
 public:
  explicit Counter(Fault fault) : fault_(fault) {
    if (fault_ == Fault::no_channels) channels_.clear();
    if (fault_ == Fault::bad_record_without_place) bad_.emplace_back();
  }
  const std::vector<Channel>& channels() const override { return channels_; }
  std::optional<Measurement> next() override {
    if (fault_ == Fault::empty || (position_ >= kCount && fault_ != Fault::endless)) {
      if (fault_ == Fault::starts_again) position_ = 0;
      return std::nullopt;
    }
    const auto n = position_++;
    auto wheels = std::make_shared<WheelSpeeds>();
    wheels->left_mps = 0.1 * static_cast<double>(n);
    if (fault_ == Fault::random) wheels->left_mps += draws_++;
    if (fault_ == Fault::nan_value) wheels->left_mps = std::nan("");
    Measurement m;
    m.stamp = m.arrival = Time{Duration{1000 * n}};
    if (fault_ == Fault::stamp_after_arrival) m.stamp += Duration{1};
    if (fault_ == Fault::arrivals_go_back && n == 5) m.stamp = m.arrival = Time{};
    m.sensor = fault_ == Fault::no_such_channel ? 3 : 0;
    m.sequence = static_cast<std::uint64_t>(fault_ == Fault::equal_sequence ? 0 : n);
    m.payload = wheels;
    if (fault_ == Fault::null_payload) m.payload = nullptr;
    if (fault_ == Fault::wrong_type) m.payload = std::make_shared<BodyTwist>();
    return m;
  }
  double progress() const override {
    return static_cast<double>(position_) / (fault_ == Fault::progress_beyond_one ? 5.0 : static_cast<double>(kCount));
  }
  const std::vector<BadRecord>& bad_records() const override { return bad_; }
  std::shared_ptr<const Reference> reference() const override {
    auto reference = std::make_shared<Reference>();
    reference->trajectory = {{Time{Duration{5}}, {}, false},
                             {Time{Duration{fault_ == Fault::reference_goes_back ? 4 : 6}}, {}, false}};
    return reference;
  }

 private:
  static constexpr std::int64_t kCount = 12;
  Fault fault_;
  std::vector<Channel> channels_{{"wheels", std::string(WheelSpeeds::kType)}};
  std::vector<BadRecord> bad_;
  std::int64_t position_ = 0;
  static inline std::atomic<int> draws_ = 0;
};

testing::Violations check(Fault fault) {
  return testing::check_source([=] { return std::make_shared<Counter>(fault); }, {.most = 1000});
}

TEST(SourceContract, AGoodSourceHasNoViolation) { EXPECT_THAT(check(Fault::none), IsEmpty()); }

TEST(SourceContract, OneSourceGivenTwiceIsAViolation) {
  const auto source = std::make_shared<Counter>(Fault::none);
  EXPECT_THAT(testing::check_source([&] { return source; }),
              Contains(StartsWith("make_source gives null or the same source twice")));
}

struct Case {
  Fault fault;
  const char* violation;  // how a violation begins
};

class FaultySource : public ::testing::TestWithParam<Case> {};

TEST_P(FaultySource, IsReported) { EXPECT_THAT(check(GetParam().fault), Contains(StartsWith(GetParam().violation))); }

INSTANTIATE_TEST_SUITE_P(
    Faults, FaultySource,
    ::testing::Values(Case{Fault::random, "two instances give different measurements"},
                      Case{Fault::endless, "the source does not end"},
                      Case{Fault::empty, "the source gives no measurement"},
                      Case{Fault::starts_again, "next gives something after the end"},
                      Case{Fault::wrong_type, "a payload is not of its channel's type"},
                      Case{Fault::no_such_channel, "a measurement belongs to no channel"},
                      Case{Fault::nan_value, "a payload has bad values"},
                      Case{Fault::null_payload, "a payload is null"},
                      Case{Fault::stamp_after_arrival, "a measurement arrives before its stamp"},
                      Case{Fault::arrivals_go_back, "measurements do not come in the order of arrival"},
                      Case{Fault::equal_sequence, "sequence numbers do not rise"},
                      Case{Fault::progress_beyond_one, "progress leaves 0..1 or falls"},
                      Case{Fault::bad_record_without_place, "a bad record has no place or no reason"},
                      Case{Fault::reference_goes_back, "the reference is not in the order of time"},
                      Case{Fault::no_channels, "the source has no channels"}));

}  // namespace
}  // namespace waymark::contract_test
