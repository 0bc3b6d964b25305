// SPDX-License-Identifier: Apache-2.0
// The kit must find faults: one map module that is good, and the same with one fault at a time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <mutex>

#include "our_plugins.hpp"
#include "waymark/testing/map_module_contract.hpp"

namespace waymark::contract_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

enum class Fault {
  none,
  refine_writes,
  random_refine,
  stale_association,
  negative_information,
  asymmetric_information,
  infinite_evidence,
  shared_storage,
  empty_clone,
  random_insert,
  forgetful_load,
  forgetful_description,
  lazy_load,
  random_extract,
  forgetful_module,
  null_observation,
  swallows_foreign_payload,
  twin_ids,
  bad_covariance,
  null_blank,
  forgetful_observation,
  lazy_observation
};

struct Sum final : Observation {
  double value = 0.0;
};

struct Count final : Association {
  int steps = 0;
};

/// What a map remembers. Locked, because the kit drives clones from several threads: a clone that shares its storage is
/// to be reported, not to corrupt memory.
class Storage {
 public:
  void add(double value) {
    const std::lock_guard lock(mutex_);
    values_.push_back(value);
  }
  void assign(std::vector<double> values) {
    const std::lock_guard lock(mutex_);
    values_ = std::move(values);
  }
  std::vector<double> values() const {
    const std::lock_guard lock(mutex_);
    return values_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<double> values_;
};

/// Remembers the mean of what it was given.
class MeanMap final : public ParticleMap {
 public:
  explicit MeanMap(Fault fault) : fault_(fault), values_(std::make_shared<Storage>()) {}

  std::unique_ptr<ParticleMap> clone() const override {
    auto copy = std::make_unique<MeanMap>(fault_);
    if (fault_ == Fault::shared_storage) {
      copy->values_ = values_;
    } else if (fault_ != Fault::empty_clone) {
      copy->values_->assign(values_->values());
    }
    return copy;
  }

  void refine(const PoseGaussian&, const Pose&, const Observation& observation, Refinement& out) const override {
    if (!out.association) out.association = std::make_unique<Count>();
    auto& count = static_cast<Count&>(*out.association);
    if (fault_ != Fault::stale_association) count.steps = 0;
    ++count.steps;
    const double nu = static_cast<const Sum&>(observation).value - mean();
    out.information = Eigen::Vector3d(1.0, 2.0, 0.0).asDiagonal();
    out.gradient = Eigen::Vector3d(nu, 0.0, 0.0);
    out.log_evidence = -0.5 * nu * nu - 0.1 * count.steps;
    if (fault_ == Fault::refine_writes) values_->add(0.0);
    if (fault_ == Fault::random_refine) out.log_evidence += draws++;
    if (fault_ == Fault::negative_information) out.information(2, 2) = -1.0;
    if (fault_ == Fault::asymmetric_information) out.information(0, 1) = 0.1;
    if (fault_ == Fault::infinite_evidence && values_->values().empty()) out.log_evidence = -HUGE_VAL;
  }

  void insert(const PoseGaussian&, const Observation& observation, const Association* association) override {
    const double noise = fault_ == Fault::random_insert ? draws++ : 0.0;
    const int steps = association == nullptr ? 0 : static_cast<const Count*>(association)->steps;
    values_->add(static_cast<const Sum&>(observation).value + steps + noise);
  }

  std::unique_ptr<ParticleMap> blank() const override {
    return fault_ == Fault::null_blank ? nullptr : std::make_unique<MeanMap>(fault_);
  }

  void describe(MapDescription& out) const override {
    const std::vector<double> values = values_->values();
    for (std::size_t i = 0; i < (fault_ == Fault::forgetful_description ? inserted_ : values.size()); ++i) {
      LandmarkView landmark;
      landmark.id = fault_ == Fault::twin_ids ? 1 : static_cast<std::int64_t>(i);
      landmark.p_map.x() = values[i];
      landmark.P(0, 0) = fault_ == Fault::bad_covariance ? -1.0 : 1.0;
      out.landmarks.push_back(landmark);
    }
  }
  void save(OutArchive& out) const override {
    out.section("mean", 1);
    out.values(values_->values());
  }
  void load(InArchive& in) {
    if (fault_ == Fault::lazy_load) return;
    in.section("mean", 1);
    std::vector<double> values;
    in.values(values);
    if (fault_ == Fault::forgetful_load) values.clear();
    inserted_ = values.size();  // what the forgetful description shows
    values_->assign(std::move(values));
  }

  static inline std::atomic<unsigned> draws = 0;

 private:
  double mean() const {
    const std::vector<double> values = values_->values();
    double sum = 0.0;
    for (const double value : values) sum += value;
    return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
  }

  Fault fault_;
  std::shared_ptr<Storage> values_;
  std::size_t inserted_ = 0;
};

/// Adds up the measurements, so that its own state matters.
class MeanModule final : public MapModule {
 public:
  explicit MeanModule(Fault fault) : fault_(fault) {}
  std::unique_ptr<ParticleMap> create_map() const override { return std::make_unique<MeanMap>(fault_); }
  std::shared_ptr<const Observation> extract(const Measurement& trigger, std::span<const Companion>,
                                             const MotionWindow&) override {
    if (fault_ == Fault::null_observation) return nullptr;
    auto sum = std::make_shared<Sum>();
    if (fault_ == Fault::swallows_foreign_payload && trigger.payload->type() != WheelSpeeds::kType) return sum;
    sum->value = total_ += trigger.as<WheelSpeeds>().left_mps;
    if (fault_ == Fault::random_extract) sum->value += MeanMap::draws++;
    return sum;
  }
  std::unique_ptr<ParticleMap> load_map(InArchive& in) const override {
    auto map = std::make_unique<MeanMap>(fault_);
    map->load(in);
    return map;
  }
  bool can_draw_again() const override { return true; }
  void save_observation(const Observation& observation, OutArchive& out) const override {
    out.value(static_cast<const Sum&>(observation).value);
  }
  std::shared_ptr<const Observation> load_observation(InArchive& in) const override {
    auto sum = std::make_shared<Sum>();
    if (fault_ != Fault::lazy_observation) in.value(sum->value);
    if (fault_ == Fault::forgetful_observation) sum->value = 0.0;
    return sum;
  }
  void save(OutArchive& out) const override { out.value(total_); }
  void load(InArchive& in) override {
    in.value(total_);
    if (fault_ == Fault::forgetful_module) total_ = 0.0;
  }

 private:
  Fault fault_;
  double total_ = 1.0;
};

testing::Violations check(Fault fault) {
  std::vector<testing::MappingStep> steps;
  for (const Measurement& m : wheel_speeds(9))
    steps.push_back({.trigger = m, .T_map_base = Pose::planar(1.0, 2.0, 0.3)});
  MeanModule module(fault);
  return testing::check_map_module(module, steps);
}

TEST(MapModuleContract, AGoodModuleHasNoViolation) { EXPECT_THAT(check(Fault::none), IsEmpty()); }

TEST(MapModuleContract, NoStepsAreAViolation) {
  MeanModule module(Fault::none);
  EXPECT_THAT(testing::check_map_module(module, {}), Contains(HasSubstr("nothing was checked")));
}

struct Case {
  Fault fault;
  const char* violation;  // how a violation begins
};

/// The name that a failing test shows.
void PrintTo(const Case& fault, std::ostream* out) { *out << fault.violation; }

class FaultyMap : public ::testing::TestWithParam<Case> {};

TEST_P(FaultyMap, IsReported) { EXPECT_THAT(check(GetParam().fault), Contains(StartsWith(GetParam().violation))); }

INSTANTIATE_TEST_SUITE_P(
    Faults, FaultyMap,
    ::testing::Values(Case{Fault::refine_writes, "refine changes the map"},
                      Case{Fault::random_refine, "two maps driven with the same observations differ"},
                      Case{Fault::stale_association, "refine depends on what an earlier step left in the association"},
                      Case{Fault::negative_information, "the information is not positive semi-definite"},
                      Case{Fault::asymmetric_information, "the information is not symmetric"},
                      Case{Fault::infinite_evidence, "the log evidence is not finite: an empty map"},
                      Case{Fault::shared_storage, "inserting into a clone changes the original"},
                      Case{Fault::shared_storage, "inserting into the original changes a clone"},
                      Case{Fault::empty_clone, "a clone is not equal to its original"},
                      Case{Fault::empty_clone, "a clone does not continue as its original would"},
                      Case{Fault::random_insert, "two maps driven with the same observations differ"},
                      Case{Fault::forgetful_load, "a loaded map writes other bytes when saved again"},
                      Case{Fault::forgetful_load, "a loaded map does not continue as the saved one"},
                      Case{Fault::forgetful_description, "a loaded map describes itself differently"},
                      Case{Fault::lazy_load, "load_map does not read all that save wrote"},
                      Case{Fault::lazy_load, "load_map accepts a stream that ends early"},
                      Case{Fault::random_extract, "extract is not deterministic"},
                      Case{Fault::forgetful_module, "the module does not continue after save and load in the middle"},
                      Case{Fault::null_observation, "extract returns null"},
                      Case{Fault::swallows_foreign_payload, "extract does not refuse a foreign payload"},
                      Case{Fault::twin_ids, "two landmarks have one id"},
                      Case{Fault::bad_covariance, "a landmark's covariance is not positive semi-definite"},
                      Case{Fault::null_blank, "blank returns null although the module can draw again"},
                      Case{Fault::forgetful_observation, "observations that were saved and loaded draw another map"},
                      Case{Fault::lazy_observation, "load_observation does not read all that save_observation wrote"},
                      Case{Fault::lazy_observation, "load_observation accepts a stream that ends early"}));

}  // namespace
}  // namespace waymark::contract_test
