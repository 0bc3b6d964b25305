// SPDX-License-Identifier: Apache-2.0
#include "waymark/testing/map_module_contract.hpp"

#include <atomic>

#include "findings.hpp"
#include "map_check.hpp"
#include "several_threads.hpp"

namespace waymark::testing {

namespace {

/// A module, its steps, and what was extracted from them.
struct Bench {
  MapModule& module;
  std::span<const MappingStep> steps;
  const MapSetting& setting;
  std::vector<std::shared_ptr<const Observation>> observations = {};

  std::shared_ptr<const Observation> extract(std::size_t k) const {
    const MappingStep& step = steps[k];
    std::vector<Companion> companions;
    for (const auto& [input, measurement] : step.companions)
      companions.push_back({input, measurement.payload ? &measurement : nullptr});
    return module.extract(step.trigger, companions, step.motion);
  }
  PoseGaussian prior(std::size_t k) const { return {steps[k].T_map_base, setting.prior}; }
  PoseGaussian kept(std::size_t k) const { return {steps[k].T_map_base, setting.kept}; }

  /// One mapping step on one map, as the host makes it.
  std::string step(ParticleMap& map, std::size_t k) const {
    Refinement refinement;
    map.refine(prior(k), steps[k].T_map_base, *observations[k], refinement);
    map.insert(kept(k), *observations[k], refinement.association.get());
    return numbers_of(refinement);
  }
  /// Steps [from, to); the refinements' numbers and the bytes of the map afterwards.
  std::string drive(ParticleMap& map, std::size_t from, std::size_t to) const {
    std::string record;
    for (std::size_t k = from; k < to; ++k) record += step(map, k);
    return record + saved(map);
  }
  std::unique_ptr<ParticleMap> driven(std::size_t to) const {
    auto map = module.create_map();
    drive(*map, 0, to);
    return map;
  }
};

std::string module_state(const MapModule& module) { return saved(module); }

void load_module_state(MapModule& module, const std::string& bytes) {
  load_from(bytes, [&](InArchive& in) { module.load(in); });
}

/// Fills the bench's observations. An observation is opaque, so a second extraction is judged by what it does to a map.
void check_extract(Bench& bench, Findings& findings) {
  const std::size_t count = bench.steps.size();
  const std::string start = module_state(bench.module);
  std::string middle;
  for (std::size_t k = 0; k < count; ++k) {
    if (k == count / 2) middle = module_state(bench.module);
    bench.observations.push_back(bench.extract(k));
    findings.require(bench.observations.back() != nullptr, "extract returns null");
    if (bench.observations.back() == nullptr) return;
  }
  const auto all = [&] { return bench.drive(*bench.module.create_map(), 0, count); };
  const std::string expected = all();
  findings.require(all() == expected,
                   "two maps driven with the same observations differ: refine or insert is not deterministic");

  const auto again_from = [&](const std::string& state, std::size_t first) {
    auto kept = bench.observations;
    load_module_state(bench.module, state);
    for (std::size_t k = first; k < count; ++k) bench.observations[k] = bench.extract(k);
    std::string result = all();
    bench.observations = std::move(kept);
    return result;
  };
  findings.require(again_from(start, 0) == expected,
                   "extract is not deterministic, or the module's save and load forget something");
  findings.require(again_from(middle, count / 2) == expected,
                   "the module does not continue after save and load in the middle");
  load_module_state(bench.module, start);
  findings.require(refuses_foreign_payload(bench.steps.front().trigger,
                                           [&](const Measurement& foreign) {
                                             bench.module.extract(foreign, {}, bench.steps.front().motion);
                                           }),
                   "extract does not refuse a foreign payload with DataError");
  load_module_state(bench.module, start);
}

void check_refine(const Bench& bench, Findings& findings) {
  const auto map = bench.module.create_map();
  Refinement reused;
  for (std::size_t k = 0; k < bench.steps.size(); ++k) {
    const std::string before = saved(*map);
    std::vector<PoseGaussian> priors = {bench.prior(k),
                                        {bench.steps[k].T_map_base, Eigen::Matrix3d::Zero()},
                                        {bench.steps[k].T_map_base, 10.0 * bench.setting.prior}};
    std::vector<std::string> expected;
    for (const PoseGaussian& prior : priors) {
      Refinement fresh;
      map->refine(prior, prior.T_map_base, *bench.observations[k], fresh);
      check_refinement(fresh, "step " + std::to_string(k), findings);
      expected.push_back(numbers_of(fresh));
      // The host keeps the association from step to step, so that its storage is used again.
      reused.information.setZero();
      reused.gradient.setZero();
      reused.log_evidence = 0.0;
      map->refine(prior, prior.T_map_base, *bench.observations[k], reused);
      findings.require(numbers_of(reused) == expected.back(),
                       "refine depends on what an earlier step left in the association");
    }
    findings.require(saved(*map) == before, "refine changes the map");

    std::vector<std::unique_ptr<ParticleMap>> clones;
    clones.reserve(12);
    for (int i = 0; i < 12; ++i) clones.push_back(map->clone());
    std::atomic<bool> same = true;
    on_several_threads(12, [&](int i) {
      try {
        const std::size_t p = static_cast<std::size_t>(i) % priors.size();
        Refinement refinement;
        clones[static_cast<std::size_t>(i)]->refine(priors[p], priors[p].T_map_base, *bench.observations[k],
                                                    refinement);
        if (numbers_of(refinement) != expected[p]) same = false;
        clones[static_cast<std::size_t>(i)]->insert(bench.kept(k), *bench.observations[k],
                                                    refinement.association.get());
      } catch (...) {
        same = false;
      }
    });
    findings.require(same, "refine or insert on clones disturb each other when several threads call them");
    findings.require(saved(*map) == before, "inserting into a clone changes the original");
    bench.step(*map, k);
    check_description(*map, findings);
  }
}

void check_clones(const Bench& bench, Findings& findings) {
  const std::size_t count = bench.steps.size();
  const std::size_t cut = count / 2;
  const auto original = bench.driven(cut);
  const std::string before = saved(*original);
  const std::string shown = description_of(*original);
  const auto continuation = [&](ParticleMap& map) { return bench.drive(map, cut, count); };
  const std::string expected = continuation(*bench.driven(cut));

  auto first = original->clone();
  const auto second = original->clone();
  findings.require(saved(*first) == before && description_of(*first) == shown, "a clone is not equal to its original");
  findings.require(continuation(*first) == expected, "a clone does not continue as its original would");
  findings.require(saved(*original) == before && description_of(*original) == shown,
                   "inserting into a clone changes the original");
  first.reset();
  findings.require(continuation(*original) == expected,
                   "a map does not continue the same after its clone was written and destroyed");
  findings.require(saved(*second) == before && description_of(*second) == shown,
                   "inserting into the original changes a clone");
  findings.require(continuation(*second) == expected,
                   "a clone does not continue the same after its original was written");
}

std::unique_ptr<ParticleMap> loaded(const Bench& bench, const std::string& bytes, Findings& findings) {
  std::unique_ptr<ParticleMap> map;
  const std::size_t left = load_from(bytes, [&](InArchive& in) { map = bench.module.load_map(in); });
  findings.require(left == 0, "load_map does not read all that save wrote", std::to_string(left) + " bytes are left");
  return map;
}

void check_saving(const Bench& bench, Findings& findings) {
  const std::size_t count = bench.steps.size();
  for (const std::size_t cut : {std::size_t{0}, std::size_t{1}, count / 2, count}) {
    const auto map = bench.driven(cut);
    const std::string bytes = saved(*map);
    findings.require(saved(*map) == bytes, "save writes something else the second time");
    const auto copy = loaded(bench, bytes, findings);
    if (!copy) {
      findings.add("load_map returns null");
      return;
    }
    findings.require(saved(*copy) == bytes, "a loaded map writes other bytes when saved again");
    findings.require(description_of(*copy) == description_of(*map), "a loaded map describes itself differently");
    findings.require(bench.drive(*copy, cut, count) == bench.drive(*map, cut, count),
                     "a loaded map does not continue as the saved one");
    findings.require(refuses_truncated(bytes, [&](InArchive& in) { bench.module.load_map(in); }),
                     "load_map accepts a stream that ends early");
  }
}

/// Two particles of one family in one archive, as in a checkpoint.
void check_saving_family(const Bench& bench, Findings& findings) {
  const std::size_t count = bench.steps.size();
  const auto parent = bench.driven(count / 2);
  const auto child = parent->clone();
  if (count > count / 2) bench.step(*child, count / 2);
  std::ostringstream stream;
  OutArchive out(stream);
  parent->save(out);
  child->save(out);
  std::istringstream back(stream.str());
  InArchive in(back);
  const auto parent_again = bench.module.load_map(in);
  const auto child_again = bench.module.load_map(in);
  findings.require(saved(*parent_again) == saved(*parent) && saved(*child_again) == saved(*child),
                   "maps that share storage do not come back from one archive");
  bench.drive(*child_again, count / 2, count);
  findings.require(saved(*parent_again) == saved(*parent), "maps loaded from one archive write into each other");
}

/// What loops need, of a module that can draw its maps again.
void check_drawing_again(const Bench& bench, Findings& findings) {
  if (!bench.module.can_draw_again()) return;
  const auto map = bench.driven(bench.steps.size());
  const auto from_observations = map->blank();
  const auto from_checkpoint = map->blank();
  if (!from_observations || !from_checkpoint) {
    findings.add("blank returns null although the module can draw again");
    return;
  }
  const std::string before = saved(*map);
  for (std::size_t k = 0; k < bench.steps.size(); ++k) {
    from_observations->insert(bench.kept(k), *bench.observations[k], nullptr);
    std::ostringstream stream;
    OutArchive out(stream);
    bench.module.save_observation(*bench.observations[k], out);
    std::shared_ptr<const Observation> copy;
    const std::size_t left = load_from(stream.str(), [&](InArchive& in) { copy = bench.module.load_observation(in); });
    findings.require(left == 0 && copy, "load_observation does not read all that save_observation wrote");
    if (!copy) return;
    from_checkpoint->insert(bench.kept(k), *copy, nullptr);
    findings.require(refuses_truncated(stream.str(), [&](InArchive& in) { bench.module.load_observation(in); }),
                     "load_observation accepts a stream that ends early");
  }
  findings.require(saved(*map) == before, "inserting into a blank map changes the original");
  findings.require(saved(*from_observations) == saved(*from_checkpoint),
                   "observations that were saved and loaded draw another map");
}

void check_empty_map(const Bench& bench, Findings& findings) {
  const auto map = bench.module.create_map();
  if (!map) {
    findings.add("create_map returns null");
    return;
  }
  check_description(*map, findings);
  Refinement refinement;
  map->refine(bench.prior(0), bench.steps[0].T_map_base, *bench.observations[0], refinement);
  check_refinement(refinement, "an empty map", findings);
}

}  // namespace

std::vector<MappingStep> straight_drive(std::span<const Measurement> triggers, double speed_m_s) {
  std::vector<MappingStep> steps;
  steps.reserve(triggers.size());
  for (const Measurement& trigger : triggers) {
    const double t = to_seconds(trigger.stamp - triggers.front().stamp);
    steps.push_back({trigger, Pose::planar(speed_m_s * t, 0.0, 0.0)});
  }
  return steps;
}

Violations check_map_module(MapModule& module, std::span<const MappingStep> steps, const MapSetting& setting) {
  Findings findings;
  if (steps.empty()) {
    findings.add("no steps, so nothing was checked");
    return findings.take();
  }
  Bench bench{module, steps, setting};
  findings.part("extract, or driving a map", [&] { check_extract(bench, findings); });
  if (bench.observations.size() != steps.size() || bench.observations.back() == nullptr) return findings.take();
  findings.part("an empty map", [&] { check_empty_map(bench, findings); });
  findings.part("refine", [&] { check_refine(bench, findings); });
  findings.part("clone or insert", [&] { check_clones(bench, findings); });
  findings.part("save or load_map", [&] { check_saving(bench, findings); });
  findings.part("save or load_map of maps that share storage", [&] { check_saving_family(bench, findings); });
  findings.part("blank, save_observation or load_observation", [&] { check_drawing_again(bench, findings); });
  return findings.take();
}

}  // namespace waymark::testing
