// SPDX-License-Identifier: Apache-2.0
// The kit must find faults: one sink that is good, and the same with one fault at a time.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <optional>
#include <stdexcept>

#include "waymark/io/output_file.hpp"
#include "waymark/testing/sink_contract.hpp"

namespace waymark::contract_test {
namespace {

using ::testing::Contains;
using ::testing::IsEmpty;
using ::testing::StartsWith;

enum class Fault {
  none,
  reads_every_key,
  ignores_a_key,
  takes_any_value,
  constructor_throws,
  constructor_writes,
  needs_a_belief,
  throws_in_three_dimensions,
  knows_all_payloads,
  needs_a_last_snapshot,
  leaves_partial_file,
  writes_beside_its_folder,
  opens_elsewhere,
  never_closes,
  counts_all_runs,
  throws_something_else,
  empty_event,
  front_throws
};

/// Writes a line for each snapshot.
class Lines final : public Sink {
 public:
  Lines(const Config& config, Fault fault) : fault_(fault) {
    if (fault_ == Fault::reads_every_key) config.ignore();
    if (fault_ == Fault::constructor_throws) throw std::runtime_error("no device");
    if (fault_ == Fault::takes_any_value) {
      config.ignore();
      name_ = "lines.txt";
    } else if (fault_ != Fault::ignores_a_key) {
      name_ = config.output({"file", "name"}, "lines.txt");
    }
    if (fault_ == Fault::constructor_writes && config.file().has_parent_path())
      std::ofstream(config.file().parent_path() / "early.txt") << "too early";
  }
  void start(const RunInfo& info) override {
    out_dir_ = info.out_dir;
    if (fault_ == Fault::throws_something_else && !std::filesystem::exists(out_dir_))
      throw std::logic_error("no folder");
    file_.emplace(out_dir_ / (name_.empty() ? "lines.txt" : name_));
    if (fault_ == Fault::counts_all_runs) file_->write(std::to_string(runs_++) + "\n");
    if (fault_ == Fault::leaves_partial_file) std::ofstream(out_dir_ / "more.txt.partial") << "begun";
    if (fault_ == Fault::writes_beside_its_folder) std::ofstream(out_dir_ / "../beside.txt") << "beside";
    if (fault_ == Fault::opens_elsewhere) elsewhere_.open(out_dir_ / "../../elsewhere.txt");
    if (fault_ == Fault::never_closes) ::open((out_dir_ / "open.txt").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
  }
  void arrived(const Measurement& measurement) override {
    if (fault_ == Fault::knows_all_payloads && !measurement.payload->problem().empty())
      throw DataError("a bad payload");
    if (fault_ == Fault::knows_all_payloads && measurement.payload->type().starts_with("waymark_testing"))
      throw DataError("an unknown payload");
  }
  void write(const Snapshot& snapshot) override {
    if (fault_ == Fault::needs_a_belief && !snapshot.started()) throw std::logic_error("no belief");
    if (fault_ == Fault::throws_in_three_dimensions && snapshot.layout().motion() == StateLayout::Motion::spatial)
      throw std::logic_error("not planar");
    if (snapshot.started()) file_->write(format_time(snapshot.stamp()) + "\n");
  }
  void front(const Belief&) override {
    if (fault_ == Fault::front_throws) throw std::logic_error("front");
  }
  std::vector<std::string> take_events() override {
    return fault_ == Fault::empty_event ? std::vector<std::string>{""} : std::vector<std::string>{};
  }
  void finish(const Snapshot* last, const RunReport&) override {
    if (fault_ == Fault::needs_a_last_snapshot && last == nullptr) throw std::logic_error("no snapshot");
    file_->commit();
  }

 private:
  Fault fault_;
  std::string name_;
  std::filesystem::path out_dir_;
  std::optional<OutputFile> file_;
  std::ofstream elsewhere_;
  static inline std::atomic<int> runs_ = 0;
};

testing::Violations check(Fault fault) {
  return testing::check_sink([=](const Config& config, const Rig&) { return std::make_shared<Lines>(config, fault); },
                             "{ file: out.txt }");
}

TEST(SinkContract, AGoodSinkHasNoViolation) { EXPECT_THAT(check(Fault::none), IsEmpty()); }

struct Case {
  Fault fault;
  const char* violation;  // how a violation begins
};

class FaultySink : public ::testing::TestWithParam<Case> {};

TEST_P(FaultySink, IsReported) { EXPECT_THAT(check(GetParam().fault), Contains(StartsWith(GetParam().violation))); }

INSTANTIATE_TEST_SUITE_P(
    Faults, FaultySink,
    ::testing::Values(Case{Fault::reads_every_key, "a key that nobody knows is taken for read"},
                      Case{Fault::ignores_a_key, "a key of the YAML is not read: "},
                      Case{Fault::takes_any_value, "a value of a wrong kind is accepted: file"},
                      Case{Fault::constructor_throws, "the constructor threw: no device"},
                      Case{Fault::constructor_writes, "the constructor writes files"},
                      Case{Fault::needs_a_belief, "a run threw: no belief"},
                      Case{Fault::throws_in_three_dimensions, "a run in three dimensions threw: not planar"},
                      Case{Fault::knows_all_payloads, "a run threw: an unknown payload"},
                      Case{Fault::needs_a_last_snapshot, "a run without a snapshot threw: no snapshot"},
                      Case{Fault::leaves_partial_file, "an incomplete file is left: a run: more.txt.partial"},
                      Case{Fault::writes_beside_its_folder,
                           "something is written outside of the output folder: ../beside.txt"},
                      Case{Fault::opens_elsewhere, "a file outside of the output folder is open for writing"},
                      Case{Fault::never_closes, "a file is still open when the sink is gone"},
                      Case{Fault::counts_all_runs, "two equal runs write different files: out.txt"},
                      Case{Fault::throws_something_else,
                           "without its folder the sink throws something else than an Error: no folder"},
                      Case{Fault::empty_event, "take_events gives a text that is empty"},
                      Case{Fault::front_throws, "front or take_events threw"}));

}  // namespace
}  // namespace waymark::contract_test
