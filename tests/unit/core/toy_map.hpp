// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
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

  void see(const Pose& T_map_base, const Eigen::Vector2d& p_map, const Eigen::Vector2d& noise);
};

/// A map of known landmarks. It localises, stores where it was written, and throws where `Fails` selects.
class ToyMap final : public ParticleMap {
 public:
  enum class Fails { never, in_refine, in_insert };

  explicit ToyMap(Fails fails) : fails_(fails) {}
  std::unique_ptr<ParticleMap> clone() const override { return std::make_unique<ToyMap>(*this); }

  void refine(const PoseGaussian& prior, const Pose&, const Observation& observation, Refinement& out) const override;

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
  /// Map number `failing` (counted from 0 in the order of creation) fails as `fails` selects.
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
  Quantity observes() const override { return Quantity::position; }
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
