// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "waymark/base/time.hpp"

namespace waymark::host {

/// Measurements that a sensor with a steady period did not deliver.
struct Gap {
  double longest_s = 0.0;     ///< longest time between the stamps of two successive measurements
  double period_s = 0.0;      ///< of the sensor, before
  std::uint64_t missing = 0;  ///< as many as would have come in that period
  std::uint64_t count = 0;    ///< gaps that followed one another within a second
};

/// "no measurement for 9.8 s (period 0.005 s): some 1960 missing".
std::string describe(const Gap& gap);

/// Looks for gaps in the stamps of one sensor, whoever lost the measurements: the sensor, a network, the queues of the
/// system or of a library.
///
/// The period is the mean of the usual steps between stamps, those within half of the median. Only a sensor of which
/// nine of ten steps are usual is watched. A step of more than five periods may be a gap. It counts once the steps are
/// usual again, if fewer measurements have come since its beginning than that time has periods: a device that stamps on
/// reception stamps a burst after a stall, and nothing of it is missing.
class GapWatch {
 public:
  /// Adds a measurement, in order of arrival. `offset`: its stamp minus its arrival. `best_offset`: that of the
  /// sensor's quickest one before; nothing if it is not known, and gaps are not looked for. A step of the stamps beyond
  /// what the quickest one permits is one of the clock. Returns a gap when it is certain, once.
  std::optional<Gap> add(Time stamp, Duration offset, std::optional<Duration> best_offset);
  /// The next stamp has no relation to those before.
  void break_off();
  /// Measurements that were missing so far.
  std::uint64_t missing() const { return missing_; }

 private:
  /// What may be a gap.
  struct Suspicion {
    Time begin{};             // stamp of the last measurement before
    Time end{};               // of the first one after the last gap
    Time first_end{};         // of the first one after the first gap
    double longest_s = 0.0;   // gap
    std::uint64_t gaps = 0;   // steps of more than five periods
    std::uint64_t since = 0;  // measurements after the beginning
    int usual = 0;            // steps
    int unusual = 0;          // longer steps, with the gaps
    int usual_in_row = 0;
  };

  void learn(double step_s);
  bool is_usual(double step_s) const;
  bool is_gap(double step_s) const;
  std::optional<Gap> follow(Time stamp, double step_s);
  std::optional<Gap> conclude();

  std::deque<double> steps_;  // the last ones [s]
  int unlearned_ = 0;         // of them, since the period was computed
  double period_s_ = 0.0;
  bool is_steady_ = false;
  std::optional<Time> newest_;
  std::optional<Suspicion> suspicion_;
  std::uint64_t missing_ = 0;
};

}  // namespace waymark::host
