// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include "checks.hpp"
#include "path_fit.hpp"

namespace waymark::host::diagnosis {

namespace {

constexpr double kSecondWay = 0.6;  // of a sensor: Doppler and position of a receiver
constexpr double kLeans = 0.5;      // of a sensor that is too noisy to agree, and looks as if it did
constexpr double kAlike = 0.25;
constexpr double kFarSigmas = 5.0;
constexpr double kToleranceSigmas = 3.0;
constexpr double kMostOfField = 3.3;  // that a heading out of a field may turn as far, or as little

std::string label(const Case& c, const Observer& observer) {
  const std::string& name = c.sensor(observer.sensor).name;
  switch (observer.kind) {
    case Observer::Kind::course:
      return name + " velocity";
    case Observer::Kind::chord:
      return name + " positions";
    case Observer::Kind::matched:
      return name + " scans";
    case Observer::Kind::measured:
      break;
  }
  return name;
}

const char* word(Ratio::Verdict verdict) {
  constexpr const char* kWords[] = {"not known", "agree", "differ", "unrelated"};
  return kWords[static_cast<int>(verdict)];
}

void report(Case& c, const char* quantity, const Observer& a, const Observer& b, const Ratio& ratio) {
  c.comparisons.push_back(
      {quantity, label(c, a), label(c, b), ratio.value, ratio.sigma, ratio.spans, word(ratio.verdict)});
}

Ratio inverse(const Ratio& ratio) {
  Ratio other = ratio;
  if (ratio.verdict == Ratio::Verdict::unrelated || ratio.low == 0.0 || ratio.high == 0.0) return other;
  other.low = 1.0 / ratio.high;
  other.high = 1.0 / ratio.low;
  if (other.low > other.high) std::swap(other.low, other.high);
  other.value = 1.0 / ratio.value;
  other.shift = -ratio.shift;
  other.sigma = ratio.sigma / (ratio.value * ratio.value);
  other.offset = -ratio.offset / ratio.value;
  other.offset_sigma = ratio.offset_sigma / std::abs(ratio.value);
  other.per_way = -ratio.per_way / ratio.value;
  other.per_way_sigma = ratio.per_way_sigma / std::abs(ratio.value);
  return other;
}

/// Who agrees with two that differ from each other is too noisy to decide between them.
void forget_vague_agreements(Agreement& agreement) {
  std::vector<std::vector<Ratio>>& ratios = agreement.ratios;
  const std::size_t n = agreement.observers.size();
  std::set<std::pair<std::size_t, std::size_t>> vague;
  for (std::size_t x = 0; x < n; ++x) {
    for (std::size_t a = 0; a < n; ++a) {
      for (std::size_t b = 0; b < n; ++b) {
        const bool is_between = ratios[x][a].verdict == Ratio::Verdict::agree &&
                                ratios[x][b].verdict == Ratio::Verdict::agree &&
                                ratios[a][b].verdict == Ratio::Verdict::differ;
        if (!is_between || std::min(ratios[x][a].sigma, ratios[x][b].sigma) < ratios[a][b].sigma) continue;
        vague.insert({{x, a}, {a, x}, {x, b}, {b, x}});
      }
    }
  }
  for (const auto& [i, j] : vague) ratios[i][j].verdict = Ratio::Verdict::unknown;
}

/// Those that agree form a group, the best known agreement first: a vague one must not bring together who differ.
void group(Agreement& agreement) {
  struct Pair {
    std::size_t first;
    std::size_t second;
    double sigma;
  };
  const std::size_t n = agreement.observers.size();
  std::vector<Pair> pairs;
  agreement.groups.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    agreement.groups[i] = static_cast<int>(i);
    for (std::size_t j = 0; j < n; ++j) {
      if (agreement.ratios[i][j].verdict == Ratio::Verdict::agree)
        pairs.push_back({i, j, agreement.ratios[i][j].sigma});
    }
  }
  std::ranges::stable_sort(pairs, {}, &Pair::sigma);
  const auto differ = [&](int one, int other) {
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) {
        const bool is_between = agreement.groups[i] == one && agreement.groups[j] == other;
        if (is_between && agreement.ratios[i][j].verdict == Ratio::Verdict::differ) return true;
      }
    }
    return false;
  };
  for (const Pair& pair : pairs) {
    const int from = agreement.groups[pair.second];
    const int to = agreement.groups[pair.first];
    if (from != to && !differ(from, to)) std::ranges::replace(agreement.groups, from, to);
  }
}

/// True if what turns by much has turned: scans and wheels, but no positions with their noise.
bool is_sure_to_turn(const Case& c, const Observer& observer) {
  const bool is_wheels = observer.kind == Observer::Kind::measured && c.sensor(observer.sensor).role() == Role::wheels;
  return is_wheels || observer.kind == Observer::Kind::matched;
}

/// A field's direction that turns too far or too little is disturbed, by iron or as the robot rolls.
bool is_disturbed(const Case& c, const Observer& observer, const Ratio& ratio) {
  if (!is_field(c, observer)) return false;
  const bool is_unrelated = ratio.verdict == Ratio::Verdict::unrelated;
  return (!is_unrelated && ratio.value < kMostOfField && ratio.value > 1.0 / kMostOfField) ||
         turns_by_tilt(c, c.sensor(observer.sensor)) > kTilts;
}

/// What has no wheels may move sideways: the path of a receiver, its course or its positions, then has nothing to do
/// with the turns of another observer, or course and positions, which agree, turn so many times as far as these that no
/// scale explains both.
bool is_free(const Case& c, const Agreement& agreement, std::size_t path, std::size_t other) {
  if (!is_of_path(agreement.observers[path]) || measured_way(c.watch) != nullptr) return false;
  const Ratio& own = agreement.ratios[path][other];
  for (std::size_t k = 0; k < agreement.observers.size(); ++k) {
    const Observer& observer = agreement.observers[k];
    if (!is_of_path(observer) || observer.sensor != agreement.observers[path].sensor) continue;
    const Ratio& twin = agreement.ratios[k][other];
    const bool are_one_path = agreement.ratios[k][path].verdict == Ratio::Verdict::agree;
    const bool differ = twin.spans > 0 && own.spans > 0 &&
                        std::abs(twin.value - own.value) > kFarSigmas * std::hypot(twin.sigma, own.sigma);
    if (twin.verdict == Ratio::Verdict::unrelated || (are_one_path && differ)) return true;
  }
  return false;
}

/// True for the positions of a receiver whose path has the shape of dead reckoning: directions from fix to fix cut the
/// corners of a robot that turns often.
bool has_same_path(const Case& c, const Observer& chords, const Observer& turns, const Track* way) {
  if (chords.kind != Observer::Kind::chord || turns.track == nullptr || way == nullptr) return false;
  return PathFit(c.sensor(chords.sensor), *turns.track, *way).turns_alike();
}

/// True for a contradiction that needs no mistake. `way`: of wheels, or null.
bool is_forgiven(const Case& c, const Agreement& agreement, std::size_t i, std::size_t j, const Track* way) {
  const Ratio& ratio = agreement.ratios[i][j];
  const bool contradicts =
      ratio.verdict == Ratio::Verdict::unrelated || (ratio.verdict == Ratio::Verdict::differ && ratio.value > 0.0);
  return contradicts &&
         (is_free(c, agreement, i, j) || is_free(c, agreement, j, i) ||
          is_disturbed(c, agreement.observers[i], ratio) || is_disturbed(c, agreement.observers[j], ratio) ||
          has_same_path(c, agreement.observers[i], agreement.observers[j], way));
}

void compare_all(Case& c, const char* quantity, Agreement& agreement, const Track* way, bool is_angle) {
  const std::vector<Observer>& observers = agreement.observers;
  const std::size_t n = observers.size();
  agreement.ratios.assign(n, std::vector<Ratio>(n));
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      // Of two tracks once; what is known over spans only is the numerator.
      if (i == j || observers[j].track == nullptr || (observers[i].track != nullptr && j < i)) continue;
      const bool is_unsigned = observers[i].is_unsigned || observers[j].is_unsigned;
      CompareOptions options;
      options.way = way;
      options.is_unsigned = is_unsigned;
      options.is_noise_above = observers[i].kind == Observer::Kind::chord;
      options.is_sure = is_angle && is_sure_to_turn(c, observers[i]);
      options.tolerance = kToleranceSigmas * std::hypot(observers[i].usual_sigma, observers[j].usual_sigma);
      if (is_angle) options.shift = best_shift(observers[i].spans, *observers[j].track);
      agreement.ratios[i][j] = compare(observers[i].spans, *observers[j].track, options);
      agreement.ratios[j][i] = inverse(agreement.ratios[i][j]);
      pairs.emplace_back(i, j);
    }
  }
  std::vector<std::pair<std::size_t, std::size_t>> forgiven;
  std::ranges::copy_if(pairs, std::back_inserter(forgiven), [&](const auto& pair) {
    return is_angle && is_forgiven(c, agreement, pair.first, pair.second, way);
  });
  for (const auto& [i, j] : forgiven) {
    for (Ratio* ratio : {&agreement.ratios[i][j], &agreement.ratios[j][i]}) {
      ratio->verdict = Ratio::Verdict::unknown;
      ratio->is_forgiven = true;
    }
  }
  for (const auto& [i, j] : pairs) report(c, quantity, observers[i], observers[j], agreement.ratios[i][j]);
}

/// A scanner's way, along the direction in which it moves, as an observer of the way.
void add_scanners(Case& c, MotionAgreement& motion, const Track* way) {
  motion.mountings.resize(c.watch.sensors().size());
  if (way == nullptr) return;
  Agreement& agreement = motion.way;
  std::size_t measured = 0;
  while (agreement.observers[measured].track != way) ++measured;
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    const WatchedSensor& sensor = c.sensor(i);
    MountingFit& mounting = motion.mountings[i];
    double late = 0.0;
    for (const Observer& turns : motion.yaw.observers) {
      const Track& yaw = c.sensor(agreement.observers[measured].sensor).yaw;
      if (turns.sensor == i && turns.kind == Observer::Kind::matched && yaw.samples() > 0)
        late = best_shift(turns.spans, yaw);
    }
    mounting = fit_mounting(sensor.steps, *way, late);
    if (!mounting.is_known) continue;
    // What moves sideways is turned, not reversed: check_mounting finds it.
    const bool backwards = std::abs(mounting.angle) > 0.75 * std::numbers::pi;
    const double direction = backwards ? mounting.angle + std::numbers::pi : mounting.angle;
    Observer observer{i, Observer::Kind::matched, nullptr, {}, 0.02, 0.0, false};
    for (const ScanStep& step : sensor.steps) {
      observer.spans.push_back(
          {step.from, step.to, step.shift.x() * std::cos(direction) + step.shift.y() * std::sin(direction)});
    }
    const double tolerance =
        kToleranceSigmas * std::hypot(observer.usual_sigma, agreement.observers[measured].usual_sigma);
    Ratio ratio;
    ratio.value = backwards ? -mounting.scale : mounting.scale;
    ratio.low = ratio.high = ratio.value;
    ratio.sigma = mounting.scale_sigma;
    ratio.spans = static_cast<long>(sensor.steps.size());
    const double beyond = backwards ? 2.0 : std::max(mounting.scale, 1.0 / mounting.scale) - 1.0 - tolerance;
    const double relative = mounting.scale_sigma / std::min(mounting.scale, 1.0);
    ratio.sigmas = std::max(0.0, beyond) / std::max(relative, 1e-6);
    // Where stamps jitter, the fit may be pulled by a few long motions; a mistake shifts most of them.
    const bool is_usual = !backwards && std::abs(mounting.median_scale - 1.0) < 3.0 * mounting.median_sigma + tolerance;
    ratio.verdict = beyond <= 0.0                     ? Ratio::Verdict::agree
                    : ratio.sigmas > 3.0 && !is_usual ? Ratio::Verdict::differ
                                                      : Ratio::Verdict::unknown;
    agreement.observers.push_back(std::move(observer));
    for (auto& row : agreement.ratios) row.emplace_back();
    agreement.ratios.emplace_back(agreement.observers.size());
    agreement.ratios.back()[measured] = ratio;
    agreement.ratios[measured].back() = inverse(ratio);
    report(c, "way", agreement.observers.back(), agreement.observers[measured], ratio);
  }
}

}  // namespace

Way way_of(const Case& c, const Observer& way) {
  const Track& left = c.sensor(way.sensor).sideways;
  return {*way.track, way.kind == Observer::Kind::measured && left.samples() > 0 ? &left : nullptr};
}

bool is_field(const Case& c, const Observer& observer) {
  const WatchedSensor& sensor = c.sensor(observer.sensor);
  return observer.kind == Observer::Kind::measured && sensor.role() == Role::heading && sensor.usual.m_base.allFinite();
}

double turns_by_tilt(const Case& c, const WatchedSensor& magnetometer) {
  constexpr double kStep = 1.0;         // [s]
  constexpr double kHalfWindow = 0.25;  // [s]
  double most = 0.0;
  for (const WatchedSensor& imu : c.watch.sensors()) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double squares = 0.0;
    double vertical = 0.0;
    double horizontal = 0.0;
    double count = 0.0;
    for (double t = kHalfWindow; t + kHalfWindow < c.watch.newest(); t += kStep) {
      const auto seen = tilted_field(magnetometer, imu, t, kHalfWindow);
      if (!seen) continue;
      sum += seen->lean;
      squares += seen->lean.squaredNorm();
      vertical += std::abs(seen->field.z());
      horizontal += seen->field.head<2>().norm();
      count += 1.0;
    }
    if (!(horizontal > 0.0)) continue;
    const double variance = std::max(0.0, squares / count - (sum / count).squaredNorm());
    most = std::max(most, std::sqrt(0.5 * variance) * vertical / horizontal);
  }
  return most;
}

double Agreement::weight(int group) const {
  std::set<std::size_t> sensors;
  double sum = 0.0;
  for (std::size_t i = 0; i < observers.size(); ++i) {
    if (groups[i] == group) sum += sensors.insert(observers[i].sensor).second ? 1.0 : kSecondWay;
  }
  for (std::size_t i = 0; i < observers.size(); ++i) {
    if (leans_to(i, group) && sensors.insert(observers[i].sensor).second) sum += kLeans;
  }
  return sum;
}

bool Agreement::leans_to(std::size_t observer, int group) const {
  bool is_near = false;
  bool is_far_from_another = false;
  for (std::size_t j = 0; j < observers.size(); ++j) {
    const Ratio& ratio = ratios[observer][j];
    if (groups[observer] == group || ratio.spans == 0) continue;
    const double off = std::abs(ratio.value - 1.0);
    if (groups[j] != group) {
      is_far_from_another = is_far_from_another || off > std::max(kAlike, kFarSigmas * ratio.sigma);
      continue;
    }
    if (ratio.verdict != Ratio::Verdict::unknown) return false;
    is_near = is_near || (observers[j].track != nullptr && off < kAlike);
  }
  return is_near && is_far_from_another;
}

const Observer* Agreement::trusted_track(const Track* except) const {
  const Observer* best = nullptr;
  for (std::size_t i = 0; i < observers.size(); ++i) {
    const Observer& observer = observers[i];
    if (observer.track == nullptr || observer.track == except || !is_trusted(i)) continue;
    if (best == nullptr || observer.usual_sigma < best->usual_sigma) best = &observer;
  }
  return best;
}

Ratio Agreement::against(std::size_t observer, int group) const {
  Ratio best;
  for (std::size_t j = 0; j < observers.size(); ++j) {
    const Ratio& ratio = ratios[observer][j];
    if (groups[j] != group || ratio.verdict == Ratio::Verdict::unknown) continue;
    if (best.verdict == Ratio::Verdict::unknown || ratio.sigma < best.sigma) best = ratio;
  }
  return best;
}

const Observer* MotionAgreement::trusted_way(const Case& c) const {
  const Observer* best = way.trusted_track();
  if (best == nullptr || !best->is_unsigned) return best;
  bool is_along = false;
  for (std::size_t i = 0; i < yaw.observers.size(); ++i) {
    const bool is_gyro = yaw.observers[i].kind == Observer::Kind::measured && !is_field(c, yaw.observers[i]);
    if (is_gyro && !yaw.is_trusted(i)) return nullptr;
    is_along = is_along || (yaw.observers[i].sensor == best->sensor && yaw.is_trusted(i));
  }
  return is_along ? best : nullptr;
}

MotionAgreement compare_motion(Case& c) {
  MotionAgreement motion;
  const Track* way = measured_way(c.watch);
  motion.yaw.observers = yaw_observers(c.watch);
  motion.way.observers = way_observers(c.watch);
  compare_all(c, "yaw", motion.yaw, way, true);
  compare_all(c, "way", motion.way, nullptr, false);
  add_scanners(c, motion, way);
  for (Agreement* agreement : {&motion.yaw, &motion.way}) {
    forget_vague_agreements(*agreement);
    group(*agreement);
  }
  return motion;
}

}  // namespace waymark::host::diagnosis
