// SPDX-License-Identifier: Apache-2.0
#include "waymark/testing/sensor_contract.hpp"

#include <fmt/format.h>

#include <cmath>
#include <set>

#include "findings.hpp"
#include "payload_numbers.hpp"
#include "update_check.hpp"
#include "waymark/math/gaussian.hpp"

namespace waymark::testing {

namespace {

void check_block(const StateBlock& block, Findings& findings) {
  std::set<std::string> names;
  for (const BlockState& state : block) {
    findings.require(!state.name.empty(), "a state of the block has no name");
    findings.require(names.insert(state.name).second, "two states of the block have one name", state.name);
    findings.require(std::isfinite(state.initial), "a state of the block starts with no finite value", state.name);
    for (const double value :
         {state.initial_sigma, state.walk_per_sqrt_s, state.walk_per_sqrt_m, state.tau_s, state.stationary_sigma}) {
      findings.require(std::isfinite(value) && value >= 0.0,
                       "a sigma, walk or time constant of the block is negative or not finite", state.name);
    }
    findings.require(state.initial_sigma > 0.0 || state.walk_per_sqrt_s > 0.0 || state.walk_per_sqrt_m > 0.0 ||
                         state.stationary_sigma > 0.0,
                     "a state of the block can never change: its sigma and its walks are zero", state.name);
  }
}

bool same_block(const StateBlock& a, const StateBlock& b) {
  const auto same = [](const BlockState& x, const BlockState& y) {
    return x.name == y.name && x.initial == y.initial && x.initial_sigma == y.initial_sigma &&
           x.walk_per_sqrt_s == y.walk_per_sqrt_s && x.walk_per_sqrt_m == y.walk_per_sqrt_m && x.tau_s == y.tau_s &&
           x.stationary_sigma == y.stationary_sigma;
  };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same);
}

/// What a sensor made of one measurement: all numbers of its updates, or the text of its refusal.
using Record = std::string;

/// One run of a sensor over some measurements under fixed circumstances.
class Bench {
 public:
  Bench(std::span<const Measurement> measurements, const StateLayout& layout, const SensorSetting& setting)
      : measurements_(measurements), layout_(layout), setting_(setting) {
    belief_.mean = setting.center;
    belief_.mean.block.resize(layout.block_size());
    for (int i = 0; i < layout.block_size(); ++i) belief_.mean.block[i] = layout.block_state(i).initial;
    belief_.P = 0.01 * ErrorMatrix::Identity(layout.size(), layout.size());
  }

  /// Processes measurements [from, to). Calls `look(measurement, updates)` for each that was not refused.
  template <class Look>
  std::vector<Record> run(Sensor& sensor, std::size_t from, std::size_t to, const Look& look) {
    std::vector<Record> records;
    for (std::size_t k = from; k < to; ++k) records.push_back(step(sensor, k, look));
    return records;
  }
  std::vector<Record> run(Sensor& sensor, std::size_t from, std::size_t to) {
    return run(sensor, from, to, [](std::size_t, const UpdateList&) {});
  }

  Prediction prediction() const {
    return {belief_, layout_, belief_.mean.block.data(), setting_.datum ? &*setting_.datum : nullptr, false};
  }

  /// True if all updates that the sensor gives for measurement k are finite at a random state; those of a refused
  /// measurement are.
  bool gives_finite_updates(Sensor& sensor, std::size_t k) {
    bool finite = true;
    Random random({.seed = setting_.seed, .slot = 1, .stamp = static_cast<std::int64_t>(k), .sensor = 0});
    const NavState state = random_state(random, setting_, layout_);
    run(sensor, k, k + 1, [&](std::size_t, const UpdateList& updates) {
      Linearization out;
      for (std::size_t u = 0; u < updates.size(); ++u) {
        const DenseModel model = evaluate(updates[u], state, layout_, out);
        finite = finite && model.residual.allFinite() && model.R.allFinite() && model.H.allFinite();
      }
    });
    return finite;
  }

 private:
  template <class Look>
  Record step(Sensor& sensor, std::size_t k, const Look& look) {
    belief_.stamp = measurements_[k].stamp;
    UpdateList updates;
    try {
      sensor.process(measurements_[k], prediction(), updates);
    } catch (const DataError& error) {
      return error.what();
    }
    Record record = fmt::format("{} updates, motion {}", updates.size(), static_cast<int>(updates.motion()));
    Linearization out;
    for (std::size_t u = 0; u < updates.size(); ++u) record += evaluate(updates[u], belief_.mean, layout_, out).bytes();
    look(k, updates);
    for (std::size_t u = 0; u < updates.size(); ++u) report(sensor, u, updates[u]);
    return record;
  }

  /// Reports to the sensor what became of its update, as the host does.
  void report(Sensor& sensor, std::size_t u, const Update& update) {
    Linearization out;
    const DenseModel model = evaluate(update, belief_.mean, layout_, out);
    if (!model.problem.empty()) return;
    const Eigen::MatrixXd S = model.H * belief_.P * model.H.transpose() + model.R;
    Outcome outcome{.update = u, .innovation = model.residual, .S = 0.5 * (S + S.transpose())};
    if (!outcome.innovation.allFinite() || !outcome.S.allFinite()) return;
    outcome.nis = gaussian::density(outcome.innovation, outcome.S).squared_mahalanobis;
    if (!std::isfinite(outcome.nis)) return;
    outcome.accepted = outcome.nis < 10.0 * out.rows();
    sensor.outcome(outcome);
  }

  std::span<const Measurement> measurements_;
  const StateLayout& layout_;
  const SensorSetting& setting_;
  Belief belief_;
};

/// Every update at random states.
std::vector<Record> check_updates(Bench& bench, Sensor& sensor, std::size_t count, const StateLayout& layout,
                                  const SensorSetting& setting, Findings& findings) {
  std::size_t seen = 0;
  auto records = bench.run(sensor, 0, count, [&](std::size_t k, const UpdateList& updates) {
    Random random({.seed = setting.seed, .slot = 0, .stamp = static_cast<std::int64_t>(k), .sensor = 0});
    std::vector<NavState> states;
    states.reserve(static_cast<std::size_t>(setting.states));
    for (int i = 0; i < setting.states; ++i) states.push_back(random_state(random, setting, layout));
    for (std::size_t u = 0; u < updates.size(); ++u) {
      ++seen;
      check_update(updates[u], states, layout, fmt::format("measurement {}, update {}", k, u), findings);
    }
  });
  findings.require(seen > 0, "no measurement gave an update, so nothing was checked",
                   records.empty() ? "no measurements" : records.front());
  return records;
}

void check_clones(Bench& bench, const Sensor& pristine, const std::vector<Record>& expected, Findings& findings) {
  const std::size_t count = expected.size();
  findings.require(bench.run(*pristine.clone(), 0, count) == expected,
                   "process is not deterministic: two clones of a new sensor differ");
  const auto rest = [&](std::size_t cut) {
    return std::vector<Record>(expected.begin() + static_cast<std::ptrdiff_t>(cut), expected.end());
  };
  const std::size_t cut = count / 2;
  const auto original = pristine.clone();
  bench.run(*original, 0, cut);
  const std::string before = saved(*original);
  auto first = original->clone();
  const auto second = original->clone();
  findings.require(bench.run(*first, cut, count) == rest(cut), "a clone does not take the whole state along");
  findings.require(saved(*original) == before, "processing on a clone changes what the original saves");
  first.reset();
  findings.require(bench.run(*original, cut, count) == rest(cut),
                   "processing on a clone changes what the original does");
  findings.require(bench.run(*second, cut, count) == rest(cut), "processing on the original changes what a clone does");
}

void check_saving(Bench& bench, const Sensor& pristine, const std::vector<Record>& expected, Findings& findings) {
  const std::size_t count = expected.size();
  for (const std::size_t cut : {std::size_t{0}, std::size_t{1}, count / 2, count - 1}) {
    const auto original = pristine.clone();
    bench.run(*original, 0, cut);
    const std::string bytes = saved(*original);
    findings.require(saved(*original) == bytes, "save writes something else the second time");
    const std::vector<Record> rest(expected.begin() + static_cast<std::ptrdiff_t>(cut), expected.end());
    for (const bool used : {false, true}) {
      const auto loaded = pristine.clone();
      if (used) bench.run(*loaded, 0, count);
      const std::string_view which = used ? "into a sensor that was used before" : "into a new sensor";
      const std::size_t left = load_from(bytes, [&](InArchive& in) { loaded->load(in); });
      findings.require(left == 0, "load does not read all that save wrote", fmt::format("{} bytes are left", left));
      findings.require(saved(*loaded) == bytes, "save after load writes other bytes", which);
      findings.require(bench.run(*loaded, cut, count) == rest, "a loaded sensor does not continue as the saved one",
                       which);
    }
    const auto victim = pristine.clone();
    findings.require(refuses_truncated(bytes, [&](InArchive& in) { victim->load(in); }),
                     "load accepts a stream that ends early");
  }
}

/// Puts NaN and infinity in the place of each number of one payload.
void check_bad_values(Bench& bench, const Sensor& pristine, std::span<const Measurement> measurements,
                      Findings& findings) {
  constexpr std::size_t kMostNumbers = 64;
  constexpr std::size_t kNext = 8;
  const std::size_t k = measurements.size() / 2;
  if (k == 0) return;
  const std::size_t end = std::min(k + 1 + kNext, measurements.size());
  const std::size_t count = std::min(count_numbers(*measurements[k].payload), kMostNumbers);
  for (std::size_t n = 0; n < count; ++n) {
    for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
      const auto sensor = pristine.clone();
      bench.run(*sensor, 0, k);
      const NumberInPlace number(*measurements[k].payload, n, bad);
      const std::string where = fmt::format("{} = {}, measurement {}", number.name(), bad, k);
      findings.part("process of a value that is not finite (" + where + ")", [&] {
        const bool finite = bench.gives_finite_updates(*sensor, k);
        findings.require(finite || !measurements[k].payload->problem().empty(),
                         "an update is not finite where a value of the payload is not known", where);
      });
      number.restore();
      findings.part("process after a value that is not finite (" + where + ")", [&] {
        for (std::size_t next = k + 1; next < end; ++next) {
          findings.require(bench.gives_finite_updates(*sensor, next), "a value that is not finite stays in the sensor",
                           where);
        }
      });
    }
  }
}

void check_start_hints(const Sensor& sensor, std::span<const Measurement> measurements, const SensorSetting& setting,
                       Findings& findings) {
  for (const Measurement& measurement : measurements) {
    try {
      const auto hint = sensor.start_hint(measurement, setting.datum ? &*setting.datum : nullptr);
      if (!hint) continue;
      const bool position = !hint->p_map_point ||
                            (hint->p_map_point->allFinite() && hint->p_base_point.allFinite() && hint->sigma_m > 0.0);
      const bool heading = !hint->yaw_rad || (std::isfinite(*hint->yaw_rad) && hint->yaw_sigma_rad > 0.0);
      findings.require(position && heading, "the start hint has values that are not finite, or no sigma");
    } catch (const DataError&) {
      continue;  // unusable measurements are allowed to say so
    }
  }
}

void check_observed_motion(const Sensor& sensor, std::span<const Measurement> measurements,
                           const SensorSetting& setting, Findings& findings) {
  const std::string before = saved(sensor);
  for (const Measurement& measurement : measurements) {
    try {
      const auto motion = sensor.observed_motion(measurement, setting.datum ? &*setting.datum : nullptr);
      if (!motion) continue;
      const bool sigmas = motion->speed_scale_sigma >= 0.0 && motion->yaw_scale_sigma >= 0.0 &&
                          motion->curvature_sigma_per_m >= 0.0 && motion->interval_s >= 0.0;
      findings.require(sigmas && motion->p_base_point.allFinite(),
                       "the observed motion has a negative sigma or interval, or a lever arm that is not finite");
    } catch (const DataError&) {
      continue;
    }
  }
  findings.require(saved(sensor) == before, "observed_motion changes the sensor");
}

}  // namespace

Violations check_sensor(const Sensor& sensor, std::span<const Measurement> measurements, StateLayout::Motion motion,
                        const SensorSetting& setting) {
  Findings findings;
  findings.part("the check", [&] {
    const auto pristine = sensor.clone();
    if (!pristine) {
      findings.add("clone returns null");
      return;
    }
    const StateBlock block = sensor.block();
    check_block(block, findings);
    findings.require(same_block(block, sensor.block()) && same_block(block, pristine->block()),
                     "block differs from call to call or on a clone");
    const std::string before = saved(sensor);
    const StateLayout layout(motion, {{"sensor", block}});
    Bench bench(measurements, layout, setting);
    const auto reference = pristine->clone();
    const auto expected = check_updates(bench, *reference, measurements.size(), layout, setting, findings);
    if (expected.empty()) return;
    findings.part("clone", [&] { check_clones(bench, *pristine, expected, findings); });
    findings.part("save or load", [&] { check_saving(bench, *pristine, expected, findings); });
    findings.part("values that are not finite", [&] { check_bad_values(bench, *pristine, measurements, findings); });
    findings.part("start_hint", [&] { check_start_hints(sensor, measurements, setting, findings); });
    findings.part("observed_motion", [&] { check_observed_motion(sensor, measurements, setting, findings); });
    findings.require(refuses_foreign_payload(measurements.front(),
                                             [&](const Measurement& foreign) {
                                               UpdateList updates;
                                               pristine->clone()->process(foreign, bench.prediction(), updates);
                                             }),
                     "process does not refuse a foreign payload with DataError");
    findings.require(saved(sensor) == before, "processing on a clone changes what the original saves");
  });
  return findings.take();
}

}  // namespace waymark::testing
