// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

#include "waymark/base/error.hpp"
#include "waymark/interface/map_module.hpp"
#include "waymark/interface/update.hpp"
#include "waymark/memory/cow.hpp"

namespace waymark::test {

/// Landmarks whose place in the map is known, seen from the base: z = Rᵀ (l − p) + noise.
struct Sighting final : Observation {
  struct One {
    Eigen::Vector2d p_map;
    Eigen::Vector2d p_base;
  };
  std::vector<One> landmarks;
  double sigma_m = 0.1;
  bool writes = true;

  void see(const Pose& T_map_base, const Eigen::Vector2d& p_map, const Eigen::Vector2d& noise) {
    const Eigen::Vector3d seen = T_map_base.inverse() * Eigen::Vector3d(p_map.x(), p_map.y(), 0.0);
    landmarks.push_back({p_map, seen.head<2>() + noise});
  }
};

/// A map of known landmarks. It localises, and remembers where it was written; number `fails` of the maps that a module
/// makes can be told to throw.
class ToyMap final : public ParticleMap {
 public:
  enum class Fails { never, in_refine, in_insert };

  explicit ToyMap(Fails fails) : fails_(fails) {}
  std::unique_ptr<ParticleMap> clone() const override { return std::make_unique<ToyMap>(*this); }

  void refine(const PoseGaussian& prior, const Pose&, const Observation& observation, Refinement& out) const override {
    if (fails_ == Fails::in_refine) throw std::runtime_error("a toy that breaks in refine");
    const auto& sighting = static_cast<const Sighting&>(observation);
    const auto rows = static_cast<Eigen::Index>(2 * sighting.landmarks.size());
    out.writes = sighting.writes;
    const Eigen::Matrix2d Rt = prior.T_map_base.q.toRotationMatrix().topLeftCorner<2, 2>().transpose();
    const double variance = sighting.sigma_m * sighting.sigma_m;
    Eigen::MatrixXd H(rows, 3);
    Eigen::VectorXd nu(rows);
    for (Eigen::Index i = 0; i < rows; i += 2) {
      const auto& one = sighting.landmarks[static_cast<std::size_t>(i / 2)];
      const Eigen::Vector2d expected = Rt * (one.p_map - prior.T_map_base.p.head<2>());
      H.block<2, 2>(i, 0) = -Rt;
      H.block<2, 1>(i, 2) = Eigen::Vector2d(expected.y(), -expected.x());
      nu.segment<2>(i) = one.p_base - expected;
    }
    out.information = H.transpose() * H / variance;
    out.gradient = H.transpose() * nu / variance;
    const Eigen::MatrixXd S = H * prior.P * H.transpose() + variance * Eigen::MatrixXd::Identity(rows, rows);
    const Eigen::LLT<Eigen::MatrixXd> factor(S);
    const Eigen::VectorXd white = factor.matrixL().solve(nu);
    out.log_evidence = -0.5 * white.squaredNorm() - Eigen::MatrixXd(factor.matrixLLT()).diagonal().array().log().sum() -
                       0.5 * static_cast<double>(rows) * std::log(2.0 * std::numbers::pi);
  }

  void insert(const PoseGaussian& pose, const Observation&, const Association*) override {
    if (fails_ == Fails::in_insert) throw std::runtime_error("a toy that breaks in insert");
    written_.write().push_back(pose.T_map_base.p.x());
  }

  void describe(MapDescription& out) const override {
    for (const double x : written_.read()) {
      LandmarkView view;
      view.p_map.x() = x;
      out.landmarks.push_back(view);
    }
  }
  void save(OutArchive& out) const override { out.values(written_.read()); }
  static std::unique_ptr<ParticleMap> load(InArchive& in) {
    auto map = std::make_unique<ToyMap>(Fails::never);
    in.values(map->written_.write());
    return map;
  }

  const std::vector<double>& written() const { return written_.read(); }

 private:
  Fails fails_;
  Cow<std::vector<double>> written_;
};

class ToyModule final : public MapModule {
 public:
  /// Map number `failing` (counted from 0 as they are made) fails as told.
  explicit ToyModule(ToyMap::Fails fails = ToyMap::Fails::never, int failing = -1) : fails_(fails), failing_(failing) {}

  std::unique_ptr<ParticleMap> create_map() const override {
    return std::make_unique<ToyMap>(made_++ == failing_ ? fails_ : ToyMap::Fails::never);
  }
  std::shared_ptr<const Observation> extract(const Measurement&, std::span<const Companion>,
                                             const MotionWindow&) override {
    return std::make_shared<Sighting>();
  }
  std::unique_ptr<ParticleMap> load_map(InArchive& in) const override { return ToyMap::load(in); }

 private:
  ToyMap::Fails fails_;
  int failing_;
  mutable int made_ = 0;
};

/// A position in the plane.
class PositionModel final : public Update {
 public:
  PositionModel(const Eigen::Vector2d& z, double sigma) : z_(z), sigma_(sigma) {}
  void linearize(const StateView& state, Linearization& out) const override {
    out.reset(2, 0);
    out.residual = z_ - state.nav.T_map_base.p.head<2>();
    out.R = sigma_ * sigma_ * Eigen::Matrix2d::Identity();
    out.position().leftCols<2>().setIdentity();
  }

 private:
  Eigen::Vector2d z_;
  double sigma_;
};

/// The body twist in the plane.
class TwistModel final : public Update {
 public:
  TwistModel(const Eigen::Vector3d& z, const Eigen::Vector3d& sigma) : z_(z), sigma_(sigma) {}
  void linearize(const StateView& state, Linearization& out) const override {
    out.reset(3, 0);
    out.residual = z_ - Eigen::Vector3d(state.nav.v_base.x(), state.nav.v_base.y(), state.nav.w_base.z());
    out.R.diagonal() = sigma_.cwiseAbs2();
    out.velocity()(0, 0) = 1.0;
    out.velocity()(1, 1) = 1.0;
    out.angular_rate()(2, 2) = 1.0;
  }

 private:
  Eigen::Vector3d z_;
  Eigen::Vector3d sigma_;
};

}  // namespace waymark::test
