// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "dock.hpp"
#include "waymark/math/gaussian.hpp"

using waymark::Observation, waymark::PoseGaussian;

/// One particle's map: where the charging dock stands.
class DockMap : public waymark::ParticleMap {
 public:
  explicit DockMap(double sigma_m) : R_(sigma_m * sigma_m * Eigen::Matrix2d::Identity()) {}
  std::unique_ptr<ParticleMap> clone() const override { return std::make_unique<DockMap>(*this); }

  void refine(const PoseGaussian& prior, const waymark::Pose&, const Observation& seen,
              waymark::Refinement& out) const override {
    if (sightings_ == 0) return;  // so it is for all particles, and the weights stay comparable
    const DockView view(prior.T_map_base, seen);
    const Eigen::Vector2d nu = dock_ - view.p_map;
    const Eigen::Matrix2d noise = P_ + R_;
    out.information = view.G.transpose() * noise.inverse() * view.G;
    out.gradient = view.G.transpose() * noise.inverse() * nu;
    out.log_evidence = waymark::gaussian::density(nu, view.G * prior.P * view.G.transpose() + noise).log_density;
  }

  void insert(const PoseGaussian& pose, const Observation& seen, const waymark::Association*) override {
    const DockView view(pose.T_map_base, seen);
    const Eigen::Matrix2d noise = R_ + view.G * pose.P * view.G.transpose();  // pose.P: what sampling kept
    if (sightings_++ == 0) P_ = 1e6 * Eigen::Matrix2d::Identity();            // it may be anywhere
    const Eigen::Matrix2d K = P_ * (P_ + noise).inverse();
    dock_ += K * (view.p_map - dock_);
    P_ -= K * P_;
  }

  void describe(waymark::MapDescription& out) const override {
    if (sightings_ == 0) return;
    out.landmarks.push_back({0, dock_, std::nan(""), Eigen::Matrix3d::Zero(), 1.0, sightings_, true});
    out.landmarks.back().P.topLeftCorner<2, 2>() = P_;
  }

  void save(waymark::OutArchive& out) const override { transfer(out, *this); }
  void load(waymark::InArchive& in) { transfer(in, *this); }

 private:
  template <class Archive, class Map>
  static void transfer(Archive& archive, Map& map) {
    archive.section("dock", 1);
    archive.value(map.sightings_);
    archive.value(map.dock_);
    archive.value(map.P_);
  }

  Eigen::Matrix2d R_;
  std::int32_t sightings_ = 0;
  Eigen::Vector2d dock_ = Eigen::Vector2d::Zero();
  Eigen::Matrix2d P_ = Eigen::Matrix2d::Zero();
};
