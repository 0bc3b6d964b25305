// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "checks.hpp"
#include "motion_advice.hpp"
#include "motion_costs.hpp"

namespace waymark::host::diagnosis {

namespace {

using Certainty = Finding::Certainty;

constexpr double kDecides = 0.45;  // by so much a group must count more, or an explanation be simpler

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

/// Adds what the contradictions of one quantity show. `seen` and `change` are called with observer, group and ratio.
template <class Seen, class Change>
void add_findings(Case& c, const Agreement& agreement, const Verdict& verdict, const std::string& check,
                  const Seen& seen, const Change& change) {
  // Whose clock is wrong is no measure for others.
  const auto is_blamed = [&](std::size_t sensor) { return c.is_blamed(sensor, "delay"); };
  if (std::ranges::all_of(sensors_of(agreement, verdict.trusted), is_blamed)) return;
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
    std::string changes = change(i, ratio);
    for (std::size_t j = 0; is_open && j < agreement.observers.size(); ++j) {
      const std::size_t other = agreement.observers[j].sensor;
      if (agreement.groups[j] != verdict.trusted || std::ranges::find(suspects, other) != suspects.end()) continue;
      suspects.push_back(other);
      if (agreement.ratios[j][i].spans > 0) changes += "; or " + change(j, agreement.ratios[j][i]);
    }
    is_open = suspects.size() > 1;  // a receiver may contradict itself
    c.add(is_open ? Certainty::one_of : Certainty::named, check, suspects,
          (is_open ? c.sensor(sensor).name + ": " : "") + seen(i, ratio), changes, ratio.sigmas);
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

/// Directions from fix to fix of a robot that reverses, and nobody says where.
void forgive_chords(Agreement& yaw) {
  for (std::size_t i = 0; i < yaw.observers.size(); ++i) {
    if (yaw.observers[i].kind != Observer::Kind::chord) continue;
    for (std::size_t j = 0; j < yaw.observers.size(); ++j) {
      for (Ratio* ratio : {&yaw.ratios[i][j], &yaw.ratios[j][i]}) {
        if (ratio->value > 0.0 && ratio->verdict == Ratio::Verdict::differ) ratio->verdict = Ratio::Verdict::unknown;
      }
    }
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
    return cost_of_yaw(c, motion, observer.sensor, ratio, scales_of(motion, observer.sensor, -1));
  };
  const auto way_cost = [&](const Observer& observer, const Ratio& ratio) {
    return cost_of_way(c, motion, observer, ratio, scales_of(motion, observer.sensor, -1));
  };
  check_swapped(c, motion);
  check_pull(c, motion.yaw);
  check_gyro_offset(c, motion.yaw);
  decide(motion.yaw, yaw_cost);
  check_beams(c, motion.yaw);
  if (check_reversals(c, motion)) forgive_chords(motion.yaw);
  // Ways first: a scale of the wheels that shows there explains their turns.
  const Verdict way = decide(motion.way, way_cost);
  add_findings(
      c, motion.way, way, "way",
      [&](std::size_t i, const Ratio& ratio) { return seen_of_way(c, motion.way, i, way.trusted, ratio); },
      [&](std::size_t i, const Ratio& ratio) {
        const Observer& observer = motion.way.observers[i];
        return change_of_way(c, observer, ratio, scales_of(motion, observer.sensor, -1));
      });
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
