// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "track.hpp"
#include "watched_sensor.hpp"

namespace waymark::host::diagnosis {

/// Change of a quantity over a stretch of time.
struct Span {
  double from;
  double to;
  double value;
};

/// One way in which a sensor observes how far the robot turned, or how far it went.
struct Observer {
  enum class Kind {
    measured,  ///< by the sensor itself
    course,    ///< direction of the motion, or speed over ground, as a receiver gives it
    chord,     ///< from one fix to the next
    matched    ///< from one scan to the next
  };
  std::size_t sensor = 0;
  Kind kind = Kind::measured;
  const Track* track = nullptr;  ///< null: known over spans only
  std::vector<Span> spans;
  double usual_sigma = 0.02;           ///< σ of its usual scale error
  double usual_curvature_per_m = 0.0;  ///< of an angle: σ of a usual turn per way
  bool is_unsigned = false;            ///< of a way: forwards and backwards are the same
};

/// True for the path of a receiver: its course, or its positions.
inline bool is_of_path(const Observer& observer) {
  return observer.kind == Observer::Kind::course || observer.kind == Observer::Kind::chord;
}

/// How many times as large one observer's changes are as another's.
struct Ratio {
  enum class Verdict { unknown, agree, differ, unrelated };
  Verdict verdict = Verdict::unknown;
  double value = 0.0;
  double low = 0.0;   ///< slope if all noise is the numerator's, …
  double high = 0.0;  ///< … or the denominator's
  double sigma = 0.0;
  double sigmas = 0.0;         ///< how far from 1, beyond what is usual
  double per_way = 0.0;        ///< of an angle: what the numerator turns more per way [rad/m]
  double per_way_sigma = 0.0;  ///< 0: not known
  double offset = 0.0;         ///< of an angle: what the numerator turns more per time [rad/s]
  double offset_sigma = 0.0;   ///< 0: not known
  double shift = 0.0;          ///< by which the numerator was taken for late [s]
  long spans = 0;
  bool is_forgiven = false;  ///< a contradiction that needs no mistake
};

/// A delay of one observer against another [s].
struct Lag {
  bool is_known = false;
  double value = 0.0;
  double sigma = 0.0;
};

/// An angle in the plane [rad].
struct Angle {
  double value = 0.0;
  double sigma = 0.0;
};

/// Spans of equal length over all that a track knows.
std::vector<Span> spans_of(const Track& track, double length, double newest);

/// How a comparison is made.
struct CompareOptions {
  const Track* way = nullptr;  ///< of an angle: a turn per way is part of the model
  bool is_unsigned = false;
  bool is_noise_above = false;  ///< all noise is the numerator's
  double tolerance = 0.06;      ///< a ratio so far from 1 is usual
  double shift = 0.0;           ///< by which the numerator is late [s]
  bool is_sure = false;         ///< the numerator's large changes are those of the robot, not noise
};

/// Ratio of the numerator's spans to the changes of a track, with a constant offset (a bias) and one per way.
Ratio compare(const std::vector<Span>& numerator, const Track& denominator, const CompareOptions& options);

/// Shift of the numerator [s] with which the two fit together best, whatever their ratio; 0 if it makes no difference.
double best_shift(const std::vector<Span>& numerator, const Track& denominator);

/// The likeliest lag, and its σ by the jackknife over blocks of the log. `costs`: −2 log likelihood of a measurement of
/// each block at the lags (k − n/2) · step.
Lag lag_of(const std::vector<std::vector<double>>& costs, double step);

/// How much later the spans show what the track shows, for a known ratio and but for a constant rate.
Lag find_lag(const std::vector<Span>& measured, const Track& track, double ratio);

}  // namespace waymark::host::diagnosis
