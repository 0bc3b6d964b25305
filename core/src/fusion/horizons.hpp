// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "estimation/process_model.hpp"
#include "fusion/committed_steps.hpp"
#include "fusion/horizon.hpp"

namespace waymark::fusion {

/// What the present and the past have in common: committed sensors and maps, counters, events, health.
class CommittedHorizon : public Horizon {
 public:
  explicit CommittedHorizon(CommittedSteps& steps) : steps_(steps) {}

  bool standing() const final { return steps_.committed().standstill.standing(); }
  bool fuses(const Measurement& m) final {
    return record(m).state.fuse.fuses(m.stamp) && record(m).mode != SensorMode::off;
  }
  bool steers(const Measurement& m) const final { return steps_.committed().record(m).mode == SensorMode::fused; }
  Sensor* sensor(const Measurement& m) final { return record(m).state.sensor.get(); }
  const Datum* datum(const Measurement& m) final { return steps_.datum(m); }
  Extraction extract(const Measurement& m) final {
    return record(m).triggers_map ? steps_.extract(m, belief()) : Extraction{};
  }
  void note_unusable(const Measurement& m, std::string_view why) final { steps_.note_unusable(m, why); }
  void take_out_of_service(const Measurement& m, std::string_view why) final {
    steps_.committed().take_out_of_service(m, why);
  }
  void conclude(const Measurement& m, UpdateResult& result) final { steps_.conclude(m, result); }

 protected:
  CommittedSteps& steps() { return steps_; }
  SensorRecord& record(const Measurement& m) { return steps_.committed().record(m); }

 private:
  CommittedSteps& steps_;
};

/// The present particles. Handles standstill, re-acquisition and biased innovations.
class PresentHorizon final : public CommittedHorizon {
 public:
  PresentHorizon(CommittedSteps& steps, const FusionSettings& settings)
      : CommittedHorizon(steps), settings_(settings) {}

  const Belief& belief() override { return filter().mixture(); }
  bool follow_motion(const Measurement& m, const UpdateList& updates) override;
  void update(const Measurement& m, std::size_t index, const Update& update, UpdateResult& result) override;
  void skip_mapping() override { filter().record_tentative_path(); }
  void map(const Measurement& m, const Extraction& extraction, UpdateResult& result) override;

 private:
  particles::ParticleFilter& filter() { return steps().committed().filter; }
  bool update_standstill(const Measurement& m, const UpdateList& updates);
  void check_for_bias(const Measurement& m, const particles::MixtureOutcome& outcome, UpdateResult& result);
  Eigen::Vector2d position();
  double heading_off(const Measurement& m, const Update& update, const Eigen::Vector2d& p,
                     const particles::MixtureOutcome& outcome);
  void inflate(const Update& update, bool is_absolute, const particles::MixtureOutcome& outcome);
  void reacquire(const Measurement& m, std::size_t index, const Update& update,
                 const particles::MixtureOutcome& outcome, const std::string& why);
  void turn(const Measurement& m, const Update& update, const particles::MixtureOutcome& outcome, double off);

  const FusionSettings& settings_;
};

/// The particles at the earlier time of a late measurement (docs/math/time.md). It weights them at their past poses;
/// standstill and re-acquisition are left to present measurements.
class PastHorizon final : public CommittedHorizon {
 public:
  /// `at`: the past particles at the measurement's stamp.
  PastHorizon(CommittedSteps& steps, particles::Instant& at) : CommittedHorizon(steps), at_(at) {}

  const Belief& belief() override { return at_.mixture(); }
  bool follow_motion(const Measurement&, const UpdateList&) override { return false; }
  void update(const Measurement& m, std::size_t index, const Update& update, UpdateResult& result) override;
  void skip_mapping() override {}
  void map(const Measurement& m, const Extraction& extraction, UpdateResult& result) override {
    steps().map(m, at_, extraction, result);
  }

 private:
  particles::Instant& at_;
};

/// The front: one Gaussian, the mixture's moments updated with measurements that are not committed yet. It has its own
/// sensors and fuse gates, so that the committed ones keep their state and another thread can use it.
class FrontHorizon final : public Horizon {
 public:
  /// `process` must outlive the object.
  FrontHorizon(const Committed& committed, const estimation::ProcessModel& process, const std::optional<Datum>& datum);

  void predict(Time to);
  /// The belief predicted to a later time.
  Belief predicted(Time to) const;
  Time stamp() const { return belief_.stamp; }
  /// The configured delay of the measurement's stamps.
  Duration delay(const Measurement& m) const { return sensors_[m.sensor].delay; }

  const Belief& belief() override { return belief_; }
  bool standing() const override { return standing_; }
  bool steers(const Measurement&) const override { return true; }
  bool fuses(const Measurement& m) override;
  Sensor* sensor(const Measurement& m) override { return sensors_[m.sensor].sensor.get(); }
  const Datum* datum(const Measurement&) override { return datum_ ? &*datum_ : nullptr; }
  bool follow_motion(const Measurement& m, const UpdateList& updates) override;
  void update(const Measurement& m, std::size_t index, const Update& update, UpdateResult& result) override;
  Extraction extract(const Measurement&) override { return {}; }
  void skip_mapping() override {}
  void map(const Measurement&, const Extraction&, UpdateResult&) override {}
  // The committed filter processes the same measurement later and reports its errors.
  void note_unusable(const Measurement&, std::string_view) override {}
  void take_out_of_service(const Measurement&, std::string_view) override {}
  void conclude(const Measurement&, UpdateResult&) override {}

 private:
  struct Own {
    std::unique_ptr<Sensor> sensor;  // a clone; null: none in service
    FuseGate fuse;
    particles::UpdatePolicy policy;
    Duration delay;
    bool steers;
  };

  const estimation::ProcessModel& process_;
  std::optional<Datum> datum_;
  Belief belief_;
  bool standing_;
  std::vector<Own> sensors_;
};

}  // namespace waymark::fusion
