// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>

#include "checks.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::host::diagnosis {

namespace {

using Certainty = Finding::Certainty;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kDecides = 0.45;  // by so much a group must count more, or an explanation be simpler
constexpr double kSame = 0.15;     // two ratios are one mistake if they differ by no more than this share
constexpr double kUnlikely = 3.0;  // cost of an explanation that takes an unusual mistake
constexpr double kUsual = 1.0;     // of one that everybody makes
constexpr double kPullSigmas = 4.0;
constexpr double kTelling = 0.2;  // of one that something else points to

bool is_near(double value, double expected) { return std::abs(value / expected - 1.0) < kSame; }

bool is_within(double value, double low, double high, double margin) {
  return value > low / margin && value < high * margin;
}

/// A sensor's ratios to the group that is not its own, as far as they are known.
struct Scales {
  std::optional<double> yaw;
  std::optional<double> way;
};

/// The same mistake in both: wheels whose turns are made of their ways.
bool is_one_scale(const WatchedSensor& sensor, const Scales& scales) {
  return sensor.usual.yaw_scales_with_speed && scales.yaw && scales.way && is_near(*scales.yaw, *scales.way);
}

/// How much a mistake takes that makes this sensor turn `ratio` times as far.
double cost_of_yaw(const Case& c, std::size_t i, const Ratio& ratio, const Scales& scales) {
  const WatchedSensor& sensor = c.sensor(i);
  if (c.is_blamed(i)) return kTelling;
  const bool mirrored = is_near(ratio.value, -1.0);
  const bool degrees = is_near(std::abs(ratio.value), 1.0 / kDegree);
  switch (sensor.role()) {
    case Role::wheels:
      if (is_one_scale(sensor, scales)) return 0.5 * kUsual;
      return ratio.verdict == Ratio::Verdict::unrelated ? kUnlikely : kUsual;
    case Role::gyro:
      if (mirrored || degrees || ratio.verdict == Ratio::Verdict::unrelated || is_near(ratio.value, kDegree))
        return kUsual;
      return kUnlikely;
    case Role::scanner:
      // Few scanners deliver mirrored scans whose beams count counter-clockwise.
      if (mirrored) return sensor.steps_backwards ? kTelling : 1.2 * kUsual;
      // Half a degree from beam to beam taken for one, or the reverse.
      return is_near(ratio.value, 2.0) || is_near(ratio.value, 0.5) ? 1.2 * kUsual : kUnlikely;
    case Role::heading:
      return mirrored || ratio.verdict == Ratio::Verdict::unrelated ? kUsual : kUnlikely;
    case Role::fix:
      return mirrored ? 1.2 * kUsual : kUnlikely;
    case Role::other:
      break;
  }
  return kUsual;
}

/// True if a receiver's speed is in another unit.
bool is_speed_unit(double ratio) {
  constexpr std::array<double, 6> kUnits{3.6, 1.0 / 3.6, 1.9438, 0.5144, 2.2369, 1000.0};
  return std::ranges::any_of(kUnits, [&](double unit) { return is_near(ratio, unit); });
}

/// Of a scanner that moves backwards: 1 if it finds its own lever arm (it is turned round), −1 if it finds the reversed
/// one (the wheels count backwards), 0 if neither is clear.
int lever_evidence(const Case& c, const MotionAgreement& motion) {
  for (std::size_t i = 0; i < motion.mountings.size(); ++i) {
    const MountingFit& mounting = motion.mountings[i];
    const Eigen::Vector2d lever = c.sensor(i).T_base_sensor.p.head<2>();
    if (!mounting.is_known || lever.norm() < 0.02) continue;
    const double shown = mounting.lever.dot(lever) / lever.norm();
    if (std::abs(shown) > 4.0 * mounting.lever_sigma.maxCoeff()) return shown > 0.0 ? 1 : -1;
  }
  return 0;
}

double cost_of_way(const Case& c, const MotionAgreement& motion, const Observer& observer, const Ratio& ratio,
                   const Scales& scales) {
  const WatchedSensor& sensor = c.sensor(observer.sensor);
  if (c.is_blamed(observer.sensor)) return kTelling;
  const bool turns_fit = scales.yaw && is_near(*scales.yaw, 1.0);
  switch (sensor.role()) {
    case Role::wheels:
      if (ratio.value < 0.0 && lever_evidence(c, motion) > 0) return kUnlikely;
      if (is_one_scale(sensor, scales)) return kTelling;
      if (sensor.usual.yaw_scales_with_speed && turns_fit) return kUnlikely;
      // Ways that are reversed while turns are right: a scanner that is turned round makes the same, and more often.
      return ratio.value < 0.0 && turns_fit ? 1.5 * kUsual : kUsual;
    case Role::scanner:
      if (ratio.value > 0.0) return is_near(ratio.value, 1000.0) || is_near(ratio.value, 0.001) ? kTelling : kUsual;
      if (const int lever = lever_evidence(c, motion); lever != 0) return lever > 0 ? 0.0 : kUnlikely;
      return sensor.steps_backwards ? kTelling : kUsual;
    case Role::fix:
      if (observer.kind == Observer::Kind::course) return is_speed_unit(ratio.value) ? kUsual : kUnlikely;
      return kUnlikely;
    default:
      break;
  }
  return kUsual;
}

std::string plus_minus(const Ratio& ratio) { return fmt::format("{:.3g} ± {:.2g}", ratio.value, ratio.sigma); }

/// Those of a group that an observer is compared with; of its own sensor, what else that observes.
std::string others(const Case& c, const Agreement& agreement, int group, const Observer& of) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < agreement.observers.size(); ++i) {
    const Observer& other = agreement.observers[i];
    if (agreement.groups[i] != group || &other == &of) continue;
    const std::string name = other.sensor != of.sensor              ? c.sensor(other.sensor).name
                             : other.kind == Observer::Kind::course ? "its own velocity"
                                                                    : "its own positions";
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

/// The line that makes a sensor's turns `ratio` times smaller.
std::string change_of_yaw(const Case& c, const Observer& observer, const Ratio& ratio, const Scales& scales) {
  const std::size_t i = observer.sensor;
  const WatchedSensor& sensor = c.sensor(i);
  const std::string& name = sensor.name;
  const double r = ratio.value;
  const bool mirrored = is_near(r, -1.0);
  const bool is_absurd = ratio.verdict == Ratio::Verdict::unrelated || !is_within(std::abs(r), 0.2, 5.0, 1.0);
  switch (sensor.role()) {
    case Role::wheels:
      if (is_absurd && sensor.payload == WheelSpeeds::kType)
        return fmt::format("source: left_mps and right_mps of {}: the sign, the unit or the column of one of them",
                           name);
      if (is_one_scale(sensor, scales)) return fmt::format("source: speeds of {} times {:.4g}", name, 1.0 / r);
      if (sensor.payload == WheelSpeeds::kType) {
        if (mirrored) return fmt::format("source: swap left_mps and right_mps of {} (or both count backwards)", name);
        if (r > 0.0) return fmt::format("sensors.{}.track_m: {:.3g} fits", name, c.setting(i, "track_m") * r);
      }
      if (sensor.payload == WheelSteering::kType) {
        if (mirrored) return fmt::format("source: steering_rad of {} times -1 (left is positive)", name);
        if (r > 10.0) return fmt::format("source: steering_rad of {} times {:.6f} (degrees)", name, kDegree);
        return fmt::format("sensors.{}.wheelbase_m: {:.3g} fits, or steering_rad times {:.3g}", name,
                           c.setting(i, "wheelbase_m") * r, 1.0 / r);
      }
      return fmt::format("source: rotation of {} times {:.4g}", name, 1.0 / r);
    case Role::gyro:
      if (ratio.verdict == Ratio::Verdict::unrelated)
        return fmt::format("sensors.{}.base_T_sensor: another of its axes points up", name);
      if (mirrored) {
        const bool is_upside_down = (sensor.T_base_sensor.q * Eigen::Vector3d::UnitZ()).z() < 0.0;
        return fmt::format("sensors.{}.base_T_sensor.roll_deg: {} fits, or the opposite sign of its rates", name,
                           is_upside_down ? 0 : 180);
      }
      if (is_near(std::abs(r), 1.0 / kDegree))
        return fmt::format("source: rates of {} times {:.9f} (degrees per second)", name, kDegree);
      return fmt::format("source: rates of {} times {:.4g}", name, 1.0 / r);
    case Role::heading:
      if (mirrored) return fmt::format("source: heading of {} times -1 (it is clockwise from north)", name);
      return fmt::format("sensors.{}: its heading does not follow the turns", name);
    case Role::scanner:
      if (ratio.verdict == Ratio::Verdict::unrelated)
        return fmt::format("source: the scans of {} do not turn with the robot: repeated ones, or another scanner",
                           name);
      if (!(r < 0.0))
        return fmt::format(
            "source: step_deg of {}, the angle from beam to beam: its scans turn {:.3g} times as far as they should",
            name, r);
      return fmt::format("source: the scans of {} are mirrored: the opposite sign of step_deg (and of start_deg)",
                         name);
    case Role::fix:
      if (mirrored && observer.kind == Observer::Kind::course)
        return fmt::format("source: the course of {} counts the wrong way round: clockwise from north is right", name);
      if (mirrored)
        return fmt::format("source: swap east and north of {}, or the sign of its longitude (east is positive)", name);
      return {};
    case Role::other:
      break;
  }
  return {};
}

std::string change_of_way(const Case& c, const Observer& observer, const Ratio& ratio) {
  const WatchedSensor& sensor = c.sensor(observer.sensor);
  const double r = ratio.value;
  if (observer.kind == Observer::Kind::chord)
    return fmt::format("source: positions of {} times {:.4g}", sensor.name, 1.0 / r);
  if (sensor.role() == Role::scanner) {
    if (r > 0.0) return fmt::format("source: ranges_m of {} times {:.4g}", sensor.name, 1.0 / r);
    return sensor.steps_backwards ? fmt::format("source: the opposite sign of step_deg of {}", sensor.name)
                                  : fmt::format("sensors.{}.base_T_sensor.yaw_deg: 180 more fits", sensor.name);
  }
  if (r < 0.0) return fmt::format("source: speeds of {} times -1", sensor.name);
  return fmt::format("source: speeds of {} times {:.4g}", sensor.name, 1.0 / r);
}

/// Two groups of equal weight, or one that counts more.
struct Verdict {
  int trusted = -1;
  int doubted = -1;  ///< if none decides: the other one
};

/// The heaviest group, and the next one that contradicts it.
Verdict weigh(const Agreement& agreement) {
  std::vector<std::pair<double, int>> groups;
  std::set<int> seen;
  for (const int group : agreement.groups) {
    if (seen.insert(group).second) groups.emplace_back(-agreement.weight(group), group);
  }
  std::ranges::sort(groups);
  Verdict verdict;
  if (groups.empty()) return verdict;
  const int first = groups.front().second;
  for (const auto& [weight, group] : groups) {
    if (group == first) continue;
    bool contradicts = false;
    for (std::size_t i = 0; i < agreement.observers.size(); ++i) {
      if (agreement.groups[i] != group) continue;
      const Ratio::Verdict v = agreement.against(i, first).verdict;
      contradicts = contradicts || v == Ratio::Verdict::differ || v == Ratio::Verdict::unrelated;
    }
    if (!contradicts) continue;
    if (-groups.front().first + weight < kDecides) verdict.doubted = group;
    break;
  }
  verdict.trusted = first;
  return verdict;
}

/// The sensor's ratio to a group, or with `group` < 0 to any other sensor; the last one that is known.
std::optional<double> scale_of(const Agreement& agreement, std::size_t sensor, int group) {
  std::optional<double> scale;
  for (std::size_t i = 0; i < agreement.observers.size(); ++i) {
    if (agreement.observers[i].sensor != sensor) continue;
    for (std::size_t j = 0; j < agreement.observers.size(); ++j) {
      const bool counts = group < 0 ? agreement.observers[j].sensor != sensor : agreement.groups[j] == group;
      const Ratio& ratio = agreement.ratios[i][j];
      if (counts && ratio.verdict != Ratio::Verdict::unknown) scale = ratio.value;
    }
  }
  return scale;
}

Scales scales_of(const MotionAgreement& motion, std::size_t sensor, int yaw_group) {
  return {scale_of(motion.yaw, sensor, yaw_group), scale_of(motion.way, sensor, -1)};
}

/// Cost of the explanation that all of a group are wrong; of the sensor that takes most.
template <class Cost>
double cost_of_group(const Agreement& agreement, int group, int other, const Cost& cost) {
  std::set<std::size_t> sensors;
  double sum = 0.0;
  for (std::size_t i = 0; i < agreement.observers.size(); ++i) {
    if (agreement.groups[i] != group) continue;
    const Ratio ratio = agreement.against(i, other);
    if (ratio.verdict == Ratio::Verdict::unknown) continue;
    if (sensors.insert(agreement.observers[i].sensor).second) sum += cost(agreement.observers[i], ratio);
  }
  return sum;
}

/// Decides between two groups by the simpler explanation, if one is; `agreement.trusted` is set then.
template <class Cost>
Verdict decide(Agreement& agreement, const Cost& cost) {
  Verdict verdict = weigh(agreement);
  if (verdict.trusted >= 0 && verdict.doubted >= 0) {
    const double first_wrong = cost_of_group(agreement, verdict.trusted, verdict.doubted, cost);
    const double second_wrong = cost_of_group(agreement, verdict.doubted, verdict.trusted, cost);
    if (first_wrong < second_wrong) std::swap(verdict.trusted, verdict.doubted);
    if (std::abs(first_wrong - second_wrong) >= kDecides) verdict.doubted = -1;
  }
  agreement.trusted = verdict.doubted < 0 ? verdict.trusted : -1;
  return verdict;
}

std::vector<std::size_t> sensors_of(const Agreement& agreement, int group) {
  std::vector<std::size_t> sensors;
  for (std::size_t i = 0; i < agreement.observers.size(); ++i) {
    const std::size_t sensor = agreement.observers[i].sensor;
    if (agreement.groups[i] == group && std::ranges::find(sensors, sensor) == sensors.end()) sensors.push_back(sensor);
  }
  return sensors;
}

std::string seen_of_yaw(const Case& c, const Agreement& agreement, std::size_t i, int group, const Ratio& ratio) {
  const std::string against = others(c, agreement, group, agreement.observers[i]);
  if (ratio.verdict == Ratio::Verdict::unrelated)
    return fmt::format("its turns have nothing to do with those of {} ({} spans)", against, ratio.spans);
  return fmt::format("it turns {} times as far as {} ({} spans)", plus_minus(ratio), against, ratio.spans);
}

std::string seen_of_way(const Case& c, const Agreement& agreement, std::size_t i, int group, const Ratio& ratio) {
  return fmt::format("its way is {} times that of {} ({} spans)", plus_minus(ratio),
                     others(c, agreement, group, agreement.observers[i]), ratio.spans);
}

/// Adds what the contradictions of one quantity show. `seen` and `change` are called with observer, group and ratio.
template <class Seen, class Change>
void add_findings(Case& c, const Agreement& agreement, const Verdict& verdict, const std::string& check,
                  const Seen& seen, const Change& change) {
  std::set<std::size_t> done;
  for (std::size_t i = 0; i < agreement.observers.size(); ++i) {
    const std::size_t sensor = agreement.observers[i].sensor;
    if (verdict.trusted < 0 || agreement.groups[i] == verdict.trusted || done.contains(sensor)) continue;
    const Ratio ratio = agreement.against(i, verdict.trusted);
    if (ratio.verdict != Ratio::Verdict::differ && ratio.verdict != Ratio::Verdict::unrelated) continue;
    done.insert(sensor);
    if (c.is_blamed(sensor)) continue;  // what is known of it explains this, too
    std::vector<std::size_t> suspects{sensor};
    bool is_open = agreement.groups[i] == verdict.doubted;
    if (is_open) {
      for (const std::size_t other : sensors_of(agreement, verdict.trusted)) {
        if (other != sensor) suspects.push_back(other);
      }
    }
    is_open = suspects.size() > 1;  // a receiver may contradict itself
    c.add(is_open ? Certainty::one_of : Certainty::named, check, suspects,
          (is_open ? c.sensor(sensor).name + ": " : "") + seen(i, ratio), change(i, ratio), ratio.sigmas);
  }
}

/// Wheels of unequal size: a turn per way that no other sensor has.
void check_pull(Case& c, const MotionAgreement& motion) {
  const Agreement& yaw = motion.yaw;
  for (std::size_t i = 0; i < yaw.observers.size(); ++i) {
    const std::size_t sensor = yaw.observers[i].sensor;
    if (c.sensor(sensor).role() != Role::wheels || c.is_blamed(sensor)) continue;
    const double usual = 3.0 * yaw.observers[i].usual_curvature_per_m;
    const Ratio* clearest = nullptr;
    std::size_t against = 0;
    int partners = 0;
    int pulling = 0;
    for (std::size_t j = 0; j < yaw.observers.size(); ++j) {
      const Ratio& ratio = yaw.ratios[i][j];
      const bool is_alike = ratio.verdict == Ratio::Verdict::agree || std::abs(std::log(std::abs(ratio.value))) < 0.4;
      if (i == j || !is_alike || !(ratio.value > 0.0) || ratio.per_way_sigma == 0.0) continue;
      ++partners;
      if (std::abs(ratio.per_way) - usual < kPullSigmas * ratio.per_way_sigma) continue;
      ++pulling;
      if (clearest != nullptr && clearest->per_way_sigma <= ratio.per_way_sigma) continue;
      clearest = &ratio;
      against = yaw.observers[j].sensor;
    }
    if (usual == 0.0 || clearest == nullptr || 2 * pulling <= partners) continue;
    const double track = c.setting(sensor, "track_m");
    const double given = c.setting(sensor, "curvature_per_m");
    const double curvature = std::isfinite(given) ? given : 0.0;
    c.add(Certainty::named, "wheels of unequal size", {sensor},
          fmt::format("it turns {:.3g} ± {:.2g} rad more per metre than {}", clearest->per_way, clearest->per_way_sigma,
                      c.sensor(against).name),
          std::isfinite(track) ? fmt::format("source: right_mps of {} times {:.3g} against left_mps",
                                             c.sensor(sensor).name, 1.0 - clearest->per_way * track)
                               : fmt::format("sensors.{}.curvature_per_m: {:.3g} fits", c.sensor(sensor).name,
                                             curvature - clearest->per_way),
          (std::abs(clearest->per_way) - usual) / clearest->per_way_sigma);
  }
}

/// A gyro that turns where nothing else does, by more than any bias.
void check_gyro_offset(Case& c, const Agreement& yaw) {
  constexpr double kMostBias = 0.1;  // [rad/s], 6 °/s
  for (std::size_t i = 0; i < yaw.observers.size(); ++i) {
    const std::size_t sensor = yaw.observers[i].sensor;
    if (c.sensor(sensor).role() != Role::gyro || c.is_blamed(sensor)) continue;
    const Ratio* clearest = nullptr;
    std::size_t against = 0;
    for (std::size_t j = 0; j < yaw.observers.size(); ++j) {
      const Ratio& ratio = yaw.ratios[i][j];
      if (yaw.observers[j].sensor == sensor || ratio.verdict != Ratio::Verdict::agree || ratio.offset_sigma == 0.0)
        continue;
      if (clearest != nullptr && clearest->offset_sigma <= ratio.offset_sigma) continue;
      clearest = &ratio;
      against = yaw.observers[j].sensor;
    }
    if (clearest == nullptr) continue;
    const double sigmas = (std::abs(clearest->offset) - kMostBias) / std::max(clearest->offset_sigma, 1e-6);
    if (sigmas < kPullSigmas) continue;
    c.add(Certainty::named, "offset", {sensor},
          fmt::format("it turns {:.3g} ± {:.2g} rad/s more than {}, standing or not; no bias of a gyro is so large",
                      clearest->offset, clearest->offset_sigma, c.sensor(against).name),
          fmt::format("source: rates of {} less {:.4g} rad/s (the value at rest)", c.sensor(sensor).name,
                      clearest->offset),
          sigmas);
  }
}

/// Beams at a wrong angle from each other: the scans turn too far, and their ways are spoilt, too.
void check_beams(Case& c, const Agreement& yaw) {
  if (yaw.trusted < 0) return;
  for (std::size_t i = 0; i < yaw.observers.size(); ++i) {
    const Observer& observer = yaw.observers[i];
    const Ratio ratio = yaw.against(i, yaw.trusted);
    const bool is_beams = observer.kind == Observer::Kind::matched && ratio.value > 0.2 && ratio.value < 5.0;
    if (!is_beams || yaw.groups[i] == yaw.trusted || c.is_blamed(observer.sensor) ||
        ratio.verdict != Ratio::Verdict::differ)
      continue;
    c.add(Certainty::named, "yaw", {observer.sensor}, seen_of_yaw(c, yaw, i, yaw.trusted, ratio),
          change_of_yaw(c, observer, ratio, {}), ratio.sigmas);
  }
}

/// Latitude and longitude swapped: the path is mirrored, and its axes are stretched by cos λ and 1 / cos φ of the
/// latitude φ and longitude λ that are there, so that its length is wrong, too.
void check_swapped(Case& c, const MotionAgreement& motion) {
  constexpr double kMargin = 1.05;
  for (const Observer& observer : motion.way.observers) {
    const WatchedSensor& sensor = c.sensor(observer.sensor);
    if (observer.kind != Observer::Kind::chord || std::isnan(sensor.latitude_deg) || c.is_blamed(observer.sensor))
      continue;
    if (std::abs(sensor.longitude_deg) > 89.0) continue;  // no latitude
    const Scales scales = scales_of(motion, observer.sensor, -1);
    if (!scales.yaw || !scales.way) continue;
    const double shorter = std::cos(sensor.latitude_deg * kDegree);
    const double longer = 1.0 / std::cos(sensor.longitude_deg * kDegree);
    const bool is_mirrored = *scales.yaw < 0.0 && is_within(-*scales.yaw, shorter / longer, longer / shorter, kMargin);
    const bool is_stretched = !is_near(*scales.way, 1.0) && is_within(*scales.way, shorter, longer, kMargin);
    if (!is_mirrored || !is_stretched) continue;
    c.add(Certainty::named, "axes", {observer.sensor},
          fmt::format("it turns {:.3g} times and goes {:.3g} times as far as others, as a path does on which latitude "
                      "and longitude are swapped",
                      *scales.yaw, *scales.way),
          fmt::format("source: swap latitude_deg and longitude_deg of {}", sensor.name), 0.0);
  }
}

}  // namespace

void check_motion(Case& c, MotionAgreement& motion) {
  const auto yaw_cost = [&](const Observer& observer, const Ratio& ratio) {
    return cost_of_yaw(c, observer.sensor, ratio, scales_of(motion, observer.sensor, -1));
  };
  const auto way_cost = [&](const Observer& observer, const Ratio& ratio) {
    return cost_of_way(c, motion, observer, ratio, scales_of(motion, observer.sensor, -1));
  };
  check_swapped(c, motion);
  check_pull(c, motion);
  check_gyro_offset(c, motion.yaw);
  decide(motion.yaw, yaw_cost);
  check_beams(c, motion.yaw);
  // Ways first: a scale of the wheels that shows there explains their turns.
  const Verdict way = decide(motion.way, way_cost);
  add_findings(
      c, motion.way, way, "way",
      [&](std::size_t i, const Ratio& ratio) { return seen_of_way(c, motion.way, i, way.trusted, ratio); },
      [&](std::size_t i, const Ratio& ratio) { return change_of_way(c, motion.way.observers[i], ratio); });
  const Verdict yaw = decide(motion.yaw, yaw_cost);
  add_findings(
      c, motion.yaw, yaw, "yaw",
      [&](std::size_t i, const Ratio& ratio) { return seen_of_yaw(c, motion.yaw, i, yaw.trusted, ratio); },
      [&](std::size_t i, const Ratio& ratio) {
        const Observer& observer = motion.yaw.observers[i];
        return change_of_yaw(c, observer, ratio, scales_of(motion, observer.sensor, yaw.trusted));
      });
}

}  // namespace waymark::host::diagnosis
