// SPDX-License-Identifier: Apache-2.0
// Loops on a checkpoint.
#include <Eigen/Cholesky>
#include <algorithm>

#include "loops/loop_closer.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/map_module.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::loops {

namespace {

using Modules = std::span<const std::shared_ptr<MapModule>>;

void serialize_observations(OutArchive& out, std::vector<MapObservation>& observations, Modules modules) {
  const auto is_in_service = [&](const MapObservation& each) {
    return modules[static_cast<std::size_t>(each.module)] != nullptr;
  };
  out.value(static_cast<std::uint64_t>(std::ranges::count_if(observations, is_in_service)));
  for (const MapObservation& each : observations) {
    if (!is_in_service(each)) continue;
    out.value(static_cast<std::uint32_t>(each.module));
    modules[static_cast<std::size_t>(each.module)]->save_observation(*each.observation, out);
  }
}

void serialize_observations(InArchive& in, std::vector<MapObservation>& observations, Modules modules) {
  const auto read = [&](InArchive& each, MapObservation& observation) {
    std::uint32_t module = 0;
    each.value(module);
    const bool fits = module < modules.size() && modules[module] != nullptr && modules[module]->can_draw_again();
    if (!fits) throw DataError("the checkpoint has an observation of a map that the configuration lacks");
    observation = {static_cast<int>(module), modules[module]->load_observation(each)};
  };
  in.each(observations, read);
}

/// Semi-definite, but for rounding.
bool is_covariance(const Eigen::Matrix3d& P) {
  const double rounding = 1e-9 * P.diagonal().cwiseAbs().sum() + 1e-15;
  return P.isApprox(P.transpose(), 1e-9) &&
         Eigen::LDLT<Eigen::Matrix3d>(P + rounding * Eigen::Matrix3d::Identity()).isPositive();
}

constexpr auto kFieldsOfRelation = [](auto& archive, Relation& relation) { archive(relation.z, relation.P); };
constexpr auto kFieldsOfLoop = [](auto& archive, Loop& loop) {
  archive(loop.from, loop.to, loop.path_chi_squared);
  kFieldsOfRelation(archive, loop.relation);
};

}  // namespace

template <class Archive>
void LoopCloser::serialize(Archive& archive, Modules modules) {
  if (archive.section("loops", 2) < 2) throw DataError("the checkpoint has an older version");
  archive.each(keyframes_, [&](auto& each, Keyframe& keyframe) {
    each(keyframe.stamp, keyframe.P, keyframe.T_map_base.p, keyframe.T_map_base.q, keyframe.xyyaw, keyframe.way,
         keyframe.anchor, keyframe.points);
    each.each(keyframe.points_base, [](auto& points, Eigen::Vector2f& p) { points(p); });
    serialize_observations(each, keyframe.observations, modules);
  });
  archive(nodes_, searched_);
  archive.each(frozen_, kFieldsOfRelation);
  archive.each(loops_, kFieldsOfLoop);
  archive.each(pending_, kFieldsOfLoop);
  bool is_accepted = accepted_.has_value();
  archive(is_accepted);
  if constexpr (Archive::kReads) accepted_ = is_accepted ? std::make_optional<Accepted>() : std::nullopt;
  if (accepted_) archive(accepted_->old_loops, accepted_->recognised, accepted_->path_is_doubted);
  archive(candidates_, misses_, found_, again_from_);
  archive.within(missed_, 0, kMostMissed);
  if constexpr (Archive::kReads) {
    const auto is_of_graph = [&](const Loop& loop) {
      return loop.from < nodes_.size() && loop.to < nodes_.size() && is_covariance(loop.relation.P);
    };
    const auto has_covariance = [](const auto& each) { return is_covariance(each.P); };
    const bool fits = std::ranges::all_of(keyframes_, has_covariance) && std::ranges::all_of(frozen_, has_covariance) &&
                      std::ranges::is_sorted(keyframes_, {}, &Keyframe::stamp) && std::ranges::is_sorted(nodes_) &&
                      std::ranges::adjacent_find(nodes_) == nodes_.end() &&
                      (nodes_.empty() ? keyframes_.empty() : nodes_.back() < keyframes_.size()) &&
                      searched_ <= nodes_.size() && again_from_ <= nodes_.size() &&
                      (frozen_.empty() || frozen_.size() < nodes_.size()) &&
                      std::ranges::all_of(candidates_, [&](std::size_t node) { return node < searched_; }) &&
                      (candidates_.empty() || searched_ < nodes_.size()) &&
                      (!accepted_ || (accepted_->old_loops < loops_.size() && accepted_->recognised < nodes_.size())) &&
                      std::ranges::all_of(loops_, is_of_graph) && std::ranges::all_of(pending_, is_of_graph);
    if (!fits) throw DataError("the checkpoint has loops that do not fit its path");
  }
}
template void LoopCloser::serialize(OutArchive& archive, Modules modules);
template void LoopCloser::serialize(InArchive& archive, Modules modules);

}  // namespace waymark::loops
