// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/calibration/innovations.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>

#include "waymark/base/error.hpp"
#include "waymark/host/robot.hpp"
#include "waymark/interface/sensor.hpp"
#include "waymark/interface/snapshot.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::calibration {

namespace {

/// While heading, twist and offsets are found at the start, innovations are large and say little.
constexpr double kSettlingSeconds = 10.0;

/// A sensor that notes the results of its updates. Clones do not: they are for what is not committed.
class NotingSensor final : public Sensor {
 public:
  NotingSensor(std::shared_ptr<Sensor> inner, std::uint32_t index, std::vector<Innovation>* notes)
      : inner_(std::move(inner)), index_(index), notes_(notes) {}

  StateBlock block() const override { return inner_->block(); }
  SensorTraits traits() const override { return inner_->traits(); }
  std::optional<StartHint> start_hint(const Measurement& m, const Datum* datum) const override {
    return inner_->start_hint(m, datum);
  }
  void process(const Measurement& m, const Prediction& prediction, UpdateList& out) override {
    measurement_ = m.sequence;
    stamp_ = m.stamp;
    inner_->process(m, prediction, out);
  }
  void outcome(const Outcome& outcome) override {
    if (notes_ != nullptr) {
      notes_->push_back(
          {measurement_, static_cast<std::uint32_t>(outcome.update), index_, stamp_, outcome.innovation, outcome.S});
    }
    inner_->outcome(outcome);
  }
  std::unique_ptr<Sensor> clone() const override {
    return std::make_unique<NotingSensor>(std::shared_ptr<Sensor>(inner_->clone()), index_, nullptr);
  }
  void save(OutArchive& out) const override { inner_->save(out); }
  void load(InArchive& in) override { inner_->load(in); }

 private:
  std::shared_ptr<Sensor> inner_;
  std::uint32_t index_;
  std::vector<Innovation>* notes_;
  std::uint64_t measurement_ = 0;
  Time stamp_;
};

/// Notes the corrections of the pose by maps.
class MapCorrections {
 public:
  explicit MapCorrections(std::vector<Innovation>& notes) : notes_(notes) {}

  void look_at(const Snapshot& snapshot) {
    if (!snapshot.started()) {
      before_.reset();
      return;
    }
    if (snapshot.fate() == Fate::mapped && before_ && snapshot.stamp() >= before_->stamp) note(snapshot);
    before_ = snapshot.belief();
  }

 private:
  void note(const Snapshot& snapshot) {
    const StateLayout& layout = snapshot.layout();
    const Belief prior = extrapolate(*before_, snapshot.stamp(), layout);
    const ErrorVector correction = boxminus(snapshot.belief().mean, prior.mean, layout);
    const Eigen::Matrix3d S = pose_covariance(prior, layout) - pose_covariance(snapshot.belief(), layout);
    Innovation one;
    one.measurement = snapshot.measurement().sequence;
    one.sensor = snapshot.measurement().sensor;
    one.stamp = snapshot.stamp();
    one.nu.resize(3);
    for (int i = 0; i < 3; ++i) one.nu(i) = correction(layout.pose_indices()[static_cast<std::size_t>(i)]);
    one.S = S;
    notes_.push_back(one);
  }

  /// The belief carried on over the short time to the scan by its own twist, without process noise.
  static Belief extrapolate(const Belief& belief, Time to, const StateLayout& layout) {
    const double dt = to_seconds(to - belief.stamp);
    Belief result = belief;
    result.stamp = to;
    const Eigen::Matrix3d R = belief.mean.T_map_base.q.toRotationMatrix();
    const Eigen::Vector3d middle = so3::exp(0.5 * dt * belief.mean.w_base) * belief.mean.v_base;
    ErrorVector delta = ErrorVector::Zero(layout.size());
    ErrorMatrix F = ErrorMatrix::Identity(layout.size(), layout.size());
    const Eigen::Vector3d moved = dt * (R * middle);
    const Eigen::Vector3d turned = dt * (R * belief.mean.w_base);
    for (int i = 0; i < 3; ++i) {
      const int p = layout.active(i);
      const int attitude = layout.active(3 + i);
      if (p >= 0) delta(p) = moved(i);
      if (attitude >= 0) delta(attitude) = turned(i);
      for (int j = 0; j < 3; ++j) {
        if (const int v = layout.active(6 + j); p >= 0 && v >= 0) F(p, v) = dt * R(i, j);
        if (const int w = layout.active(9 + j); attitude >= 0 && w >= 0) F(attitude, w) = dt * R(i, j);
      }
    }
    // A rotation about the vertical axis displaces the motion that follows it.
    if (const int yaw = layout.active(5); yaw >= 0 && layout.active(0) >= 0 && layout.active(1) >= 0) {
      F(layout.active(0), yaw) = -moved.y();
      F(layout.active(1), yaw) = moved.x();
    }
    boxplus(result.mean, delta, layout);
    result.P = F * belief.P * F.transpose();
    return result;
  }

  std::vector<Innovation>& notes_;
  std::optional<Belief> before_;
};

}  // namespace

Run run_over_log(const std::filesystem::path& yaml, const std::vector<Config::Override>& overrides,
                 std::optional<double> until_s, const std::vector<std::string>& inputs) {
  host::Robot robot = host::Robot::load(yaml, overrides);
  if (robot.source == nullptr || robot.live_input != nullptr)
    throw Error(fmt::format("{}: calibration needs a log", yaml.string()));
  Run run;
  for (std::size_t i = 0; i < robot.sensors.size(); ++i) {
    SensorSlot& slot = robot.sensors[i];
    run.sensors.push_back(slot.name);
    if (slot.sensor && std::ranges::find(inputs, slot.name) == inputs.end())
      slot.sensor = std::make_shared<NotingSensor>(slot.sensor, static_cast<std::uint32_t>(i), &run.innovations);
  }
  MapCorrections corrections(run.innovations);
  const std::unique_ptr<Fusion> fusion = robot.fusion([&](const Snapshot& snapshot) { corrections.look_at(snapshot); });
  std::optional<Time> first;
  Time last;
  std::uint64_t number = 0;
  while (std::optional<Measurement> m = robot.source->next()) {
    m->sequence = number++;
    if (!first) first = m->arrival;
    last = std::max(last, m->arrival);
    if (until_s && to_seconds(m->arrival - *first) > *until_s) break;
    if (robot.assign(*m)) fusion->add(std::move(*m));
  }
  fusion->finish();
  if (!fusion->started()) throw Error(fmt::format("{}: the filter has not started: see waymark run", yaml.string()));
  run.duration_s = first ? to_seconds(last - *first) : 0.0;
  if (first) {
    const Time settled = *first + from_seconds(std::min(kSettlingSeconds, 0.1 * run.duration_s));
    std::erase_if(run.innovations, [&](const Innovation& one) { return one.stamp < settled; });
  }
  std::ranges::stable_sort(run.innovations, {}, &Innovation::id);
  return run;
}

}  // namespace waymark::calibration
