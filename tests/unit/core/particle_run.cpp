// SPDX-License-Identifier: Apache-2.0
#include "unit/core/particle_run.hpp"

#include <sstream>
#include <utility>

namespace waymark::test {

ParticleRun::ParticleRun(const ParticleFilterSettings& settings, std::vector<std::shared_ptr<MapModule>> modules)
    : modules_(static_cast<int>(modules.size())), filter_(process_, std::move(modules), settings) {}

Belief ParticleRun::prior() const {
  Belief belief;
  belief.P = ErrorMatrix::Zero(6, 6);
  belief.P.diagonal() << 1.0, 1.0, 0.09, 0.25, 0.04, 0.04;
  belief.mean.block = BlockVector::Zero(0);
  return belief;
}

void ParticleRun::drive(int from, int to) {
  for (int k = from; k < to; ++k) {
    const double t = 0.1 * (k + 1);
    Random noise({77, 0, k, 0});
    filter_.predict(at(t), false);
    filter_.update(TwistModel({1.0 + 0.1 * noise.normal(), 0.0, 0.2 * noise.normal()}, {0.1, 0.1, 0.2}), {});
    filter_.update(PositionModel({t + 0.3 * noise.normal(), 0.3 * noise.normal()}, 0.3), {});
    map(Pose::planar(t, 0.0, 0.0), noise);
  }
}

std::vector<std::pair<int, std::string>> ParticleRun::map(const Pose& truth, Random& noise) {
  Sighting sighting;
  for (const Eigen::Vector2d& landmark : {Eigen::Vector2d(5.0, 3.0), Eigen::Vector2d(2.0, -4.0)}) {
    const double x = 0.1 * noise.normal();
    const double y = 0.1 * noise.normal();
    sighting.see(truth, landmark, {x, y});
  }
  std::vector<particles::MappingInput> inputs;
  for (int i = 0; i < modules_; ++i) inputs.push_back({i, &sighting, 1.0, true});
  return filter_.map(inputs, 3);
}

std::string ParticleRun::bytes() const {
  std::ostringstream stream;
  OutArchive out(stream);
  filter_.save(out);
  return stream.str();
}

void ParticleRun::restore(const std::string& bytes) {
  std::istringstream stream(bytes);
  InArchive in(stream);
  filter_.load(in);
}

std::vector<gaussian::Density> densities(ParticleRun& run, const Update& model) {
  std::vector<gaussian::Density> result;
  for (const particles::Particle& particle : run.filter().particles()) {
    Linearization linear;
    estimation::ekf::Innovation innovation;
    model.linearize({particle.belief.mean, nullptr}, linear);
    test::innovate(particle.belief, run.layout(), 0, linear, innovation);
    result.push_back(innovation.density);
  }
  return result;
}

std::vector<double> log_evidences(ParticleRun& run, const Update& model) {
  std::vector<double> result;
  for (const auto& density : densities(run, model)) result.push_back(density.log_density);
  return result;
}

std::vector<double> squared_distances(ParticleRun& run, const Update& model) {
  std::vector<double> result;
  for (const auto& density : densities(run, model)) result.push_back(density.squared_mahalanobis);
  return result;
}

}  // namespace waymark::test
