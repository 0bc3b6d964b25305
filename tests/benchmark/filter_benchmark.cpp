// SPDX-License-Identifier: Apache-2.0
// What the filter costs: one measurement of the EKF, resampling, and a whole step of the particle filter among
// landmarks.
#include <benchmark/benchmark.h>

#include <cmath>
#include <memory>
#include <vector>

#include "estimation/ekf.hpp"
#include "particles/particle_filter.hpp"
#include "particles/resampling.hpp"
#include "unit/core/beliefs.hpp"
#include "unit/core/toy_map.hpp"
#include "waymark/interface/map_module.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark {
namespace {

/// One prediction over 25 ms and one twist update, as a wheel odometry asks for.
void ekf_measurement(benchmark::State& state) {
  const auto motion = state.range(0) == 0 ? StateLayout::Motion::planar : StateLayout::Motion::spatial;
  const StateLayout layout(motion, {{"wheels", test::block_of(3)}});
  const estimation::ProcessModel process(layout, {});
  Belief belief;
  belief.mean.v_base.x() = 1.0;
  belief.mean.block = BlockVector::Zero(3);
  belief.P = 0.01 * ErrorMatrix::Identity(layout.size(), layout.size());
  const test::TwistModel twist({1.0, 0.0, 0.1}, {0.1, 0.1, 0.05});
  Linearization model;
  estimation::StateJacobian H;
  estimation::ekf::Innovation innovation;
  for (auto _ : state) {
    process.predict(belief, belief.stamp + from_seconds(0.025), false);
    twist.linearize({belief.mean, belief.mean.block.data()}, model);
    H.reset(model.rows(), layout.size());
    estimation::scatter(layout, 0, model, H);
    estimation::ekf::innovate(belief, model, H, innovation);
    estimation::ekf::apply(belief, layout, innovation);
    benchmark::DoNotOptimize(belief);
  }
  state.SetLabel(std::to_string(layout.size()) + " error states");
}
BENCHMARK(ekf_measurement)->ArgName("spatial")->Arg(0)->Arg(1);

/// Ancestors of a systematic resampling.
void resampling(benchmark::State& state) {
  std::vector<double> log_weights(static_cast<std::size_t>(state.range(0)));
  Random random = test::stream(1);
  for (double& w : log_weights) w = random.normal();
  particles::normalize_log_weights(log_weights);
  for (auto _ : state) benchmark::DoNotOptimize(particles::systematic_resample(log_weights, 0.37));
}
BENCHMARK(resampling)->ArgName("particles")->RangeMultiplier(10)->Range(10, 10000);

/// A robot circles among trees eight metres apart, all mapped by every particle; it sees seven at a time, up to 25 m
/// away. Others in view are judged as missed, but a miss costs them nothing, so that the map stays as it is.
class Orchard {
 public:
  Orchard(int particles, int threads, int landmarks)
      : layout_(StateLayout::Motion::planar, {{"wheels", test::block_of(3)}}), process_(layout_, {}) {
    const PluginLoader loader({WAYMARK_PLUGIN_DIR});
    const Config yaml = Config::parse(
        "{ inputs: [camera], extraction: { range_max_m: 1e5 }, noise: { range_m: 0.1, bearing_deg: 0.5 },"
        "  association: { min_separation_m: 0.3 }, existence: { view_range_m: 25, log_odds_miss: 0 } }");
    const Rig rig(std::vector<Mounting>{
        {.name = "camera", .payload = "waymark/LandmarkObservations@1", .T_base_sensor = Pose()}});
    module_ = loader.create<MapModule>("feature_map", yaml, rig);
    ParticleFilterSettings settings;
    settings.particles = particles;
    settings.threads = threads;
    filter_ = std::make_unique<particles::ParticleFilter>(process_, std::vector<std::shared_ptr<MapModule>>{module_},
                                                          settings);
    Belief prior;
    prior.mean.v_base.x() = 1.0;
    prior.mean.block = BlockVector::Zero(3);
    prior.P = 1e-6 * ErrorMatrix::Identity(layout_.size(), layout_.size());
    filter_->start(prior, false);
    const int side = static_cast<int>(std::ceil(std::sqrt(landmarks)));
    for (int i = 0; i < landmarks; ++i)
      landmarks_.emplace_back(8.0 * (i % side - side / 2), 8.0 * (i / side - side / 2));
    const Eigen::Vector2d center(0.0, 10.0);  // of the circle that speed and turn rate below make
    for (const Eigen::Vector2d& p : landmarks_) {
      if ((p - center).norm() < 15.0) near_.push_back(p);
    }
    for (int k = 0; k < 4; ++k) {  // all are seen often enough to count
      see(landmarks_);
      map();
    }
  }

  /// Eight odometry measurements and one of seven landmarks.
  void step() {
    const test::TwistModel twist({1.0, 0.0, 0.1}, {0.1, 0.1, 0.05});
    for (int k = 0; k < 8; ++k) {
      filter_->predict(filter_->stamp() + from_seconds(0.025), false);
      filter_->update(twist, {});
    }
    std::vector<Eigen::Vector2d> seven;
    for (std::size_t k = 0; k < 7; ++k) seven.push_back(near_[(counter_ + k) % near_.size()]);
    ++counter_;
    see(seven);
    map();
  }

 private:
  void see(const std::vector<Eigen::Vector2d>& landmarks) {
    auto seen = std::make_shared<LandmarkObservations>();
    const Pose T_base_map = filter_->mixture().mean.T_map_base.inverse();
    for (const Eigen::Vector2d& p : landmarks) {
      const Eigen::Vector3d d = T_base_map * Eigen::Vector3d(p.x(), p.y(), 0.0);
      seen->landmarks.push_back({.range_m = d.head<2>().norm(), .bearing_rad = std::atan2(d.y(), d.x())});
    }
    observation_ = module_->extract({.stamp = filter_->stamp(), .sensor = 0, .payload = seen}, {}, {});
  }
  void map() { filter_->map(std::vector<particles::MappingInput>{{0, observation_.get(), 1.0, true}}, 0); }

  StateLayout layout_;
  estimation::ProcessModel process_;
  std::shared_ptr<MapModule> module_;
  std::unique_ptr<particles::ParticleFilter> filter_;
  std::vector<Eigen::Vector2d> landmarks_;
  std::vector<Eigen::Vector2d> near_;
  std::shared_ptr<const Observation> observation_;
  std::size_t counter_ = 0;
};

void whole_step(benchmark::State& state) {
  Orchard orchard(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)), static_cast<int>(state.range(2)));
  for (auto _ : state) orchard.step();
  state.counters["per_particle"] = benchmark::Counter(static_cast<double>(state.iterations() * state.range(0)),
                                                      benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(whole_step)
    ->ArgNames({"particles", "threads", "landmarks"})
    ->Args({1, 1, 400})
    ->Args({100, 1, 100})
    ->Args({100, 1, 400})
    ->Args({100, 1, 1600})
    ->Args({100, 1, 6400})
    ->Args({100, 2, 400})
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();

}  // namespace
}  // namespace waymark

BENCHMARK_MAIN();
