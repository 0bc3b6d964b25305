// SPDX-License-Identifier: Apache-2.0
#include "waymark/host/diagnosis.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "checks.hpp"
#include "watch.hpp"

namespace waymark::host {

namespace {

constexpr double kFirst = 30.0;  // [s] of the log before the first evaluation

bool is_same(const Finding& a, const Finding& b) {
  return a.check == b.check && !a.sensors.empty() && !b.sensors.empty() && a.sensors.front() == b.sensors.front();
}

bool contains(const std::vector<Finding>& findings, const Finding& finding) {
  return std::ranges::any_of(findings, [&](const Finding& other) { return is_same(other, finding); });
}

/// True for what a part of the window may show by its noise alone, and the whole of it does not.
bool is_of_whole_window(const Finding& finding) {
  return finding.check == "way" || finding.check == "height" || finding.check == "lever arm" ||
         finding.check == "delay" || finding.check == "heading";
}

bool is_of_motion(const Finding& finding) {
  return finding.check == "yaw" || finding.check == "way" || finding.check == "axes";
}

}  // namespace

struct Diagnosis::Parts {
  explicit Parts(const Robot& of) : robot(of), watch(of) {}

  const Robot& robot;
  diagnosis::Watch watch;
  double next = kFirst;
  std::vector<Finding> last;  // of the evaluation before, in this window
  std::vector<Finding> findings;
  std::size_t of_earlier_windows = 0;  // so many of the findings
  std::size_t taken = 0;
  std::vector<Comparison> comparisons;

  /// True if the turns of its sensor contradict those of any other one.
  bool is_contradicted(const Finding& finding, const diagnosis::Agreement& yaw) const {
    for (std::size_t i = 0; i < yaw.observers.size(); ++i) {
      if (watch.sensors()[yaw.observers[i].sensor].name != finding.sensors.front()) continue;
      const bool differs = std::ranges::any_of(yaw.ratios[i], [](const diagnosis::Ratio& ratio) {
        return ratio.verdict == diagnosis::Ratio::Verdict::differ ||
               ratio.verdict == diagnosis::Ratio::Verdict::unrelated;
      });
      if (differs) return true;
    }
    return false;
  }

  /// True if the whole window shows the IMU of a finding to be mounted as the YAML has it, or to lean into curves, so
  /// that its accelerations show nothing.
  bool accelerates_along_its_axes(const Finding& finding, const diagnosis::Case& c,
                                  const diagnosis::MotionAgreement& motion) const {
    constexpr double kAlong = 10.0 * diagnosis::kDegree;
    constexpr double kSigmas = 2.0;
    for (std::size_t i = 0; i < watch.sensors().size(); ++i) {
      if (watch.sensors()[i].name != finding.sensors.front()) continue;
      const diagnosis::Observer* way = motion.trusted_way(c);
      const diagnosis::Observer* yaw = motion.yaw.trusted_track();
      if (way != nullptr && yaw != nullptr &&
          diagnosis::leans_into_curves(watch.sensors()[i], *way->track, *yaw->track, watch.newest()))
        return true;
      const auto angle = diagnosis::beside_acceleration(c, motion, i);
      return angle && std::abs(angle->value) + kSigmas * angle->sigma < kAlong;
    }
    return false;
  }

  /// The evaluation of a whole window withdraws what a part of it seemed to show, where it names another sensor.
  void withdraw(const diagnosis::Case& c, const diagnosis::MotionAgreement& motion) {
    const std::vector<Finding>& of_window = c.findings;
    const auto is_withdrawn = [&](const Finding& early) {
      if (contains(of_window, early)) return false;
      if (early.check == "acceleration" && accelerates_along_its_axes(early, c, motion)) return true;
      return is_of_whole_window(early) || (early.check == "yaw" && !is_contradicted(early, motion.yaw)) ||
             std::ranges::any_of(of_window, [&](const Finding& other) {
               // Heights that are wrong make slopes, and so accelerations, wrong; and so do ways.
               const bool is_of_slope =
                   (other.check == "height" || other.check == "way") && early.check == "acceleration";
               const bool is_rival =
                   other.check == early.check || is_of_slope || (is_of_motion(other) && is_of_motion(early));
               return is_rival && other.certainty == Finding::Certainty::named;
             });
    };
    const auto begin = findings.begin() + static_cast<std::ptrdiff_t>(std::min(of_earlier_windows, findings.size()));
    findings.erase(std::remove_if(begin, findings.end(), is_withdrawn), findings.end());
    taken = std::min(taken, findings.size());
    of_earlier_windows = findings.size();
  }

  /// What two evaluations in a row find is certain; at the end of a window, or of the log, one is enough.
  void evaluate(bool is_last, bool at_end = false) {
    diagnosis::Case c{watch, robot};
    diagnosis::check_magnitudes(c);
    diagnosis::check_frozen(c);
    diagnosis::check_directions(c);
    diagnosis::check_unsigned_wheels(c);
    diagnosis::MotionAgreement motion = diagnosis::compare_motion(c);
    diagnosis::check_shifted_clocks(c, motion.yaw);
    diagnosis::check_clock_rates(c, motion.yaw);
    const std::vector<diagnosis::FieldMounting> fields = diagnosis::check_field_axes(c);
    diagnosis::check_motion(c, motion);
    diagnosis::check_deviations(c, motion);
    diagnosis::check_own_velocities(c);
    diagnosis::check_backwards(c, motion);
    diagnosis::check_sideways(c, motion);
    diagnosis::check_paths(c, motion);
    diagnosis::check_mounting(c, motion);
    diagnosis::check_delays(c, motion);
    diagnosis::check_scatters(c, motion);
    diagnosis::check_imu_axes(c, motion);
    diagnosis::check_heights(c, motion);
    diagnosis::check_climbs(c, motion);
    diagnosis::check_accelerations(c, motion);
    diagnosis::check_slopes(c, motion);
    diagnosis::check_field_mountings(c, motion, fields);
    diagnosis::check_dips(c, motion);
    if (at_end) diagnosis::check_clocks(c);
    for (const Finding& finding : c.findings) {
      if (!is_last && !contains(last, finding)) continue;
      const auto known = std::ranges::find_if(findings, [&](const Finding& f) { return is_same(f, finding); });
      if (known == findings.end()) {
        // What was open between several is decided.
        if (finding.certainty == Finding::Certainty::named) {
          std::erase_if(findings, [&](const Finding& f) {
            return f.certainty == Finding::Certainty::one_of && f.check == finding.check &&
                   std::ranges::find(f.sensors, finding.sensors.front()) != f.sensors.end();
          });
          taken = std::min(taken, findings.size());
        }
        findings.push_back(finding);
      } else {
        const Time stamp = known->stamp;
        *known = finding;  // by now with more data
        known->stamp = stamp;
      }
    }
    if (is_last) withdraw(c, motion);
    last = std::move(c.findings);
    comparisons = std::move(c.comparisons);
  }
};

Diagnosis::Diagnosis(const Robot& robot) : parts_(std::make_unique<Parts>(robot)) {}

Diagnosis::~Diagnosis() = default;

void Diagnosis::arrived(const Measurement& measurement) {
  Parts& parts = *parts_;
  parts.watch.take(measurement);
  if (parts.watch.is_full()) {
    parts.evaluate(true);
    parts.watch.clear_window();
    parts.next = kFirst;
    parts.last.clear();
  } else if (parts.watch.newest() >= parts.next) {
    parts.evaluate(false);
    parts.next *= 2.0;
  }
}

void Diagnosis::note(const Measurement& measurement) { parts_->watch.note(measurement); }

bool Diagnosis::has_all_sensors() const { return parts_->watch.has_all_sensors(); }

void Diagnosis::finish() {
  if (parts_->watch.newest() > 0.0) parts_->evaluate(true, true);
}

const std::vector<Finding>& Diagnosis::findings() const { return parts_->findings; }

std::vector<Finding> Diagnosis::take_new() {
  std::vector<Finding> fresh(parts_->findings.begin() + static_cast<std::ptrdiff_t>(parts_->taken),
                             parts_->findings.end());
  parts_->taken = parts_->findings.size();
  return fresh;
}

const std::vector<Comparison>& Diagnosis::comparisons() const { return parts_->comparisons; }

}  // namespace waymark::host
