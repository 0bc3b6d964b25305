// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "dead_reckoning.hpp"
#include "field_turns.hpp"
#include "lever_fit.hpp"
#include "observers.hpp"
#include "watch.hpp"
#include "waymark/host/diagnosis.hpp"
#include "waymark/interface/finding.hpp"

namespace waymark::host::diagnosis {

inline constexpr double kDegree = std::numbers::pi / 180.0;

/// What the checks share: the data, the YAML, and what earlier checks have found.
struct Case {
  const Watch& watch;
  const Robot& robot;
  std::vector<Finding> findings = {};
  std::vector<Comparison> comparisons = {};

  const WatchedSensor& sensor(std::size_t index) const { return watch.sensors()[index]; }
  /// True if a finding names this sensor.
  bool is_blamed(std::size_t index) const;
  /// True if a finding names this sensor, alone or as one of several.
  bool is_concerned(std::size_t index) const;
  /// True if a finding of this kind names this sensor.
  bool is_blamed(std::size_t index, std::string_view check) const;
  /// True for heights of a receiver, or of an altimeter where they count; not of one that a finding concerns.
  bool has_heights(std::size_t index) const;
  /// Number of the YAML under `sensors.<name>.<key>`; NaN if it is not there.
  double setting(std::size_t index, std::string_view key) const;
  void add(Finding::Certainty certainty, std::string check, const std::vector<std::size_t>& suspects, std::string seen,
           std::string change, double sigmas);
};

/// How far a difference is beyond what is usual, in σ; 0 where it is not. The tolerance is where the usual ends, which
/// nobody knows exactly: for a difference that is well known, 1 σ beyond it is enough, if it is clearly more than half
/// of it.
inline double beyond(double difference, double tolerance, double sigma) {
  const double size = std::abs(difference);
  if (size < tolerance + sigma) return 0.0;
  const bool is_well_known = sigma < 0.25 * tolerance;
  return (size - (is_well_known ? 0.5 : 1.0) * tolerance) / sigma;
}

/// How far a heading may be off: its own σ, within what is usual [rad].
double heading_tolerance(const WatchedSensor& sensor);

/// Magnitudes that no robot has: units, stamps, gravity, the Earth's field, the place on the Earth.
void check_magnitudes(Case& c);

/// Positions and headings that do not change while the robot moves.
void check_frozen(Case& c);

/// At the end of a log: sensors that delivered nothing, and clocks that run hours apart.
void check_clocks(Case& c);

/// Displacements that do not point along the x axis of the base, or not where scans show them.
void check_directions(Case& c);

/// Which observers of a quantity agree with each other.
struct Agreement {
  std::vector<Observer> observers;
  std::vector<std::vector<Ratio>> ratios;  ///< [numerator][denominator]
  std::vector<int> groups;                 ///< of each observer: those with one number agree
  int trusted = -1;                        ///< the group that is taken for right; -1: none is

  bool is_trusted(std::size_t observer) const { return trusted >= 0 && groups[observer] == trusted; }
  /// How much a group counts: its sensors, a little for one that observes in two ways, and for one that leans to it.
  double weight(int group) const;
  /// True if the observer's ratio to a track of the group is near 1, but not known well enough to agree or to differ,
  /// and far from 1 to another observer.
  bool leans_to(std::size_t observer, int group) const;
  /// A trusted observer that is known at all times, not `except`; null if there is none.
  const Observer* trusted_track(const Track* except = nullptr) const;
  /// Ratio of an observer to those of a group, the best known one; unknown if there is none.
  Ratio against(std::size_t observer, int group) const;
};

/// A ratio, and the sensor that it is to.
struct Partner {
  const Ratio* ratio = nullptr;
  std::size_t sensor = 0;
};

/// Of the ratios of observer `i` that count, the one with the smallest `sigma`; `counts` is called with each of them.
template <class Counts>
Partner best_known(const Agreement& agreement, std::size_t i, double Ratio::*sigma, const Counts& counts) {
  Partner best;
  for (std::size_t j = 0; j < agreement.observers.size(); ++j) {
    const Ratio& ratio = agreement.ratios[i][j];
    if (i == j || ratio.*sigma == 0.0 || !counts(ratio, agreement.observers[j].sensor)) continue;
    if (best.ratio == nullptr || ratio.*sigma < best.ratio->*sigma) best = {&ratio, agreement.observers[j].sensor};
  }
  return best;
}

/// What the comparisons of turns and ways gave.
struct MotionAgreement {
  Agreement yaw;
  Agreement way;
  std::vector<MountingFit> mountings;  ///< of each sensor; known of scanners only

  /// A trusted way along the x axis of the base; null if there is none. A receiver's is one only if its course turns as
  /// all gyros do.
  const Observer* trusted_way(const Case& c) const;
};

/// The way of an observer, with what its sensor measures to the left.
Way way_of(const Case& c, const Observer& way);

/// True for a heading out of a magnetic field, whose direction turns late and early as the robot rolls.
bool is_field(const Case& c, const Observer& observer);

/// How far a heading out of a field that is not levelled turns as the robot tilts, or as it accelerates, so that
/// gravity seems to tilt (σ) [rad]: by the tilt times the tangent of the field's dip. 0 if nothing measures it.
double turns_by_tilt(const Case& c, const WatchedSensor& magnetometer);
inline constexpr double kTilts = 4.0 * kDegree;  // more, and such a heading proves little

/// By how much the robot drives beside a heading, as positions show; nothing if it is not known.
std::optional<Angle> beside_heading(const Case& c, const MotionAgreement& motion, std::size_t heading);

/// The same of a robot that is taken to move forwards all the time: nobody's way counts.
std::optional<Angle> positions_beside_heading(const Case& c, std::size_t heading);

/// The same by the path of the positions against dead reckoning, where the robot turns too often for directions.
std::optional<Angle> beside_path(const Case& c, const MotionAgreement& motion, std::size_t receiver,
                                 const Track& heading);

/// By how much the specific force points beside the accelerations of the motion; nothing if it is not known.
std::optional<Angle> beside_acceleration(const Case& c, const MotionAgreement& motion, std::size_t imu);

/// Compares all turns with each other, and all ways.
MotionAgreement compare_motion(Case& c);

/// How far a clock is behind, exactly where it is by the leap seconds, and that it is by those.
struct ClockShift {
  double behind;         ///< [s]
  std::string_view why;  ///< empty: not known
};
ClockShift shift_of_clock(double behind);

/// Clocks that differ by seconds to a minute, as that of GPS without leap seconds: turns that fit only far apart in
/// time.
void check_shifted_clocks(Case& c, const Agreement& yaw);

/// Clocks that run too fast or too slow: turns that are the farther behind those of others, the later it is.
void check_clock_rates(Case& c, const Agreement& yaw);

/// Wheels of unequal size: a turn per way that no other sensor has.
void check_pull(Case& c, const Agreement& yaw);

/// A gyro that turns where nothing else does, by more than any bias.
void check_gyro_offset(Case& c, const Agreement& yaw);

/// Names who does not fit: scales, signs, units, track width. Decides which group is trusted.
void check_motion(Case& c, MotionAgreement& motion);

/// Headings that are off by what changes with the heading, as iron makes it; their noise against the σ that the YAML
/// gives.
void check_deviations(Case& c, const MotionAgreement& motion);

/// A gyro and a magnetometer of which one is turned about the vertical axis, or the field's vertical axis over.
struct FieldMounting {
  std::size_t imu = 0;
  std::size_t magnetometer = 0;
  FieldTurns turns;
};

/// The magnetic field against the turns of a gyro: its scale, and axes of either that are mirrored or in another order.
/// Returns those that are turned, or of which the field alone does not show who it is.
std::vector<FieldMounting> check_field_axes(Case& c);

/// Who of those it is, as headings and accelerations show.
void check_field_mountings(Case& c, const MotionAgreement& motion, const std::vector<FieldMounting>& mountings);

/// True if a magnetic field points down in the north, and up in the south; nothing where it may do either.
std::optional<bool> points_as_the_earths(const Case& c, std::size_t magnetometer);

/// The magnetic field against gravity: as the robot tilts, the angle between them stays.
void check_dips(Case& c, const MotionAgreement& motion);

/// A way that is counted forwards where positions go backwards. Returns whether there is one.
bool check_reversals(Case& c, const MotionAgreement& motion);

/// A speed to the left with the wrong sign, by the path of positions.
void check_sideways(Case& c, const MotionAgreement& motion);

/// Wheels whose speeds have lost their signs, by the turns of others.
void check_unsigned_wheels(Case& c);

/// Speeds without a sign of their own against accelerations and headings: one of them faces backwards.
void check_backwards(Case& c, const MotionAgreement& motion);

/// A receiver's velocity, summed up, against its own positions: of a time that is seconds away.
void check_own_velocities(Case& c);

/// Positions against dead reckoning over tens of seconds: mirrored, or late by seconds.
void check_paths(Case& c, const MotionAgreement& motion);

/// Headings against the direction of the motion; where scanners and antennas stand.
void check_mounting(Case& c, const MotionAgreement& motion);

/// Whether an antenna stands where the YAML has it.
void check_antenna(Case& c, std::size_t i, const AntennaFit& antenna);

/// Least scatter of positions that is no motion of a robot whose wheels, or whose scans, take the motion out [m].
inline constexpr double kSlipScatter = 0.06;

/// White noise of positions against the σ that the YAML, or the fix itself, claims. `scatter`: what was found, per
/// axis; `motion`: so much of it may be the robot's own motion [m].
void check_scatter(Case& c, std::size_t i, double scatter, double motion);

/// The same for positions that no dead reckoning is there for.
void check_scatters(Case& c, const MotionAgreement& motion);

/// Heights of an altimeter against those of others, where the robot moves in space: scale, sign, level, unit.
void check_heights(Case& c, const MotionAgreement& motion);

/// True if heights that differ by so much [m] do so by more than the receiver's errors, which wander.
bool exceeds_wander(const WatchedSensor& receiver, double difference);

/// Acceleration of the base forwards and to the left at a time [m/s²]; nothing if it is not known.
std::optional<Eigen::Vector2d> acceleration(const Track& way, const Track& yaw, double t);

/// An IMU by itself: gravity in its specific force turns as its gyro does, or the axes of one of them are in another
/// order or have other signs.
void check_imu_axes(Case& c, const MotionAgreement& motion);

/// The specific force in the plane against the accelerations of the motion: how an IMU is turned about its vertical
/// axis.
void check_accelerations(Case& c, const MotionAgreement& motion);

/// True for a vehicle whose IMU feels its accelerations forwards and none in curves: it leans into them.
bool leans_into_curves(const WatchedSensor& imu, const Track& way, const Track& yaw, double newest);

/// Heights against the slopes that gravity shows: in another unit.
void check_climbs(Case& c, const MotionAgreement& motion);

/// The specific force along the way against accelerations, slopes and the vertical: signs of its axes, an IMU that is
/// tilted.
void check_slopes(Case& c, const MotionAgreement& motion);

/// Delays between the sensors.
void check_delays(Case& c, const MotionAgreement& motion);

}  // namespace waymark::host::diagnosis
