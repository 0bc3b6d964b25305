// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "unit/core/toy_map.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::test {

/// Where one particle's match finds the base, and how well it fits there.
struct Opinion {
  Eigen::Vector3d pose;  ///< x [m], y [m], yaw [rad]
  double log_evidence = 0.0;
  Eigen::Vector3d slip = Eigen::Vector3d::Zero();             ///< variance
  std::optional<double> log_evidence_without = std::nullopt;  ///< set: it lies beyond what the prior expects
};

constexpr double kOpinionSigma = 1e-3;  // of every match, [m] and [rad]

/// A map that returns its opinion whatever was observed.
class OpinionMap final : public ParticleMap {
 public:
  /// The opinions are those of the maps of all particles in turn.
  OpinionMap(std::shared_ptr<const std::vector<Opinion>> opinions, std::size_t particle)
      : opinions_(std::move(opinions)), particle_(particle) {}
  std::unique_ptr<ParticleMap> clone() const override { return std::make_unique<OpinionMap>(*this); }
  void refine(const PoseGaussian& prior, const Pose&, const Observation&, Refinement& out) const override {
    const Opinion& opinion = (*opinions_)[particle_ % opinions_->size()];
    const Pose& mean = prior.T_map_base;
    Eigen::Vector3d d = opinion.pose - Eigen::Vector3d(mean.p.x(), mean.p.y(), mean.yaw());
    d.z() = so3::wrap(d.z());
    out.information = Eigen::Matrix3d::Identity() / (kOpinionSigma * kOpinionSigma);
    out.gradient = out.information * d;
    out.log_evidence = opinion.log_evidence;
    out.slip = opinion.slip.asDiagonal();
    if (opinion.log_evidence_without) {
      out.jump = {.d = d,
                  .information = Eigen::Matrix3d::Zero(),
                  .gradient = Eigen::Vector3d::Zero(),
                  .log_evidence = *opinion.log_evidence_without,
                  .failed = true};
    }
  }
  void insert(const PoseGaussian&, const Observation&, const Association*) override {}
  void describe(MapDescription&) const override {}
  void save(OutArchive&) const override {}

 private:
  std::shared_ptr<const std::vector<Opinion>> opinions_;
  std::size_t particle_;
};

/// Gives the maps of the particles their opinions in turn.
class OpinionModule final : public MapModule {
 public:
  explicit OpinionModule(std::vector<Opinion> opinions)
      : opinions_(std::make_shared<std::vector<Opinion>>(std::move(opinions))) {}
  /// From now on.
  void change(std::vector<Opinion> opinions) { *opinions_ = std::move(opinions); }
  std::unique_ptr<ParticleMap> create_map() const override { return std::make_unique<OpinionMap>(opinions_, made_++); }
  std::shared_ptr<const Observation> extract(const Measurement&, std::span<const Companion>,
                                             const MotionWindow&) override {
    return nullptr;
  }
  std::unique_ptr<ParticleMap> load_map(InArchive&) const override { return create_map(); }

 private:
  std::shared_ptr<std::vector<Opinion>> opinions_;
  mutable std::size_t made_ = 0;
};

}  // namespace waymark::test
