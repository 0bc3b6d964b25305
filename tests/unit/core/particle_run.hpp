// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "particles/particle_filter.hpp"
#include "unit/core/beliefs.hpp"
#include "unit/core/toy_map.hpp"

namespace waymark::test {

/// A filter in the plane with all that must outlive it, and a drive that exercises everything.
class ParticleRun {
 public:
  explicit ParticleRun(const ParticleFilterSettings& settings, std::vector<std::shared_ptr<MapModule>> modules = {});

  particles::ParticleFilter& filter() { return filter_; }
  const estimation::ProcessModel& process() const { return process_; }
  const StateLayout& layout() const { return layout_; }

  Belief prior() const;

  /// Steps `from` … `to` − 1: predict, twist, position, and a mapping step with all modules in service.
  void drive(int from, int to);

  /// One mapping step: two landmarks seen from `truth` by every module.
  std::vector<std::pair<int, std::string>> map(const Pose& truth, Random& noise);

  std::string bytes() const;
  void restore(const std::string& bytes);

 private:
  StateLayout layout_{StateLayout::Motion::planar, {{"sensor", {}}}};
  estimation::ProcessModel process_{layout_, {{0.5, 0.1, 0.0}, {0.0, 0.0, 0.3}}};
  int modules_;
  particles::ParticleFilter filter_;
};

std::vector<gaussian::Density> densities(ParticleRun& run, const Update& model);

/// What each particle's log evidence of an update is, before it is applied.
std::vector<double> log_evidences(ParticleRun& run, const Update& model);

std::vector<double> squared_distances(ParticleRun& run, const Update& model);

}  // namespace waymark::test
