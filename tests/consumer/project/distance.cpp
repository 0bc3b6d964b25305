// SPDX-License-Identifier: Apache-2.0
// A sink: how far the robot has driven, as a table over time.
#include <optional>

#include "waymark/io/output_file.hpp"
#include "waymark/plugin.hpp"

using namespace waymark;

namespace {

class Distance : public Sink {
 public:
  explicit Distance(const Config& config)
      : name_(config.output({"file", "name in the output folder"}, "distance.csv")) {}

  void start(const RunInfo& info) override {
    file_.emplace(info.out_dir / name_);
    file_->write("t_s,distance_m\n");
  }

  void write(const Snapshot& snapshot) override {
    if (!snapshot.started() || snapshot.fate() != Fate::fused) return;
    const double interval = last_ ? to_seconds(snapshot.stamp() - *last_) : 0.0;
    last_ = snapshot.stamp();
    distance_m_ += interval * snapshot.belief().mean.v_base.norm();
    file_->write(format_time(*last_) + ',' + std::to_string(distance_m_) + '\n');
  }

  void finish(const Snapshot*, const RunReport&) override { file_->commit(); }

 private:
  std::string name_;
  std::optional<OutputFile> file_;
  std::optional<Time> last_;
  double distance_m_ = 0.0;
};

}  // namespace

WAYMARK_PLUGIN(Sink, Distance, "distance", "1.0.0")
