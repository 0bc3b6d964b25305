// SPDX-License-Identifier: Apache-2.0
#include "late_paths.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace waymark::indoor_gps {
namespace {

/// An innovation that a late path explains is not one for the gate: its NIS stays below this (2σ).
constexpr double kExplainedNis = 4.0;

/// Mills' ratio (1 − Φ(x))/φ(x).
double mills(double x) {
  constexpr double kLargestExponent = -35.0;  // beyond it the ratio only says that the Gaussian is negligible
  constexpr double kContinued = 8.0;
  x = std::max(x, kLargestExponent);
  if (x < kContinued) {
    const double density = std::exp(-0.5 * x * x) / std::sqrt(2.0 * std::numbers::pi);
    return 0.5 * std::erfc(x / std::numbers::sqrt2) / density;
  }
  double tail = x;  // Laplace's continued fraction
  for (int k = 30; k >= 1; --k) tail = x + k / tail;
  return 1.0 / tail;
}

/// A density and its first two derivatives, over the Gaussian density.
struct Ratios {
  double f = 0.0, df = 0.0, ddf = 0.0;
};

/// The Gaussian with an exponential excess of mean τ. f solves τ f' + f = N, which gives its derivatives.
Ratios with_excess(double nu, double variance, double tau) {
  const double s = std::sqrt(variance);
  Ratios r;
  r.f = s / tau * mills(s / tau - nu / s);
  r.df = (1.0 - r.f) / tau;
  r.ddf = (-nu / variance - r.df) / tau;
  return r;
}

}  // namespace

EquivalentInnovation LatePaths::equivalent(double nu, double variance, bool is_difference) const {
  if (share_ <= 0.0) return {nu, variance};
  const double direct = is_difference ? 1.0 - 2.0 * share_ : 1.0 - share_;
  const Ratios late = with_excess(nu, variance, mean_excess_);
  Ratios sum{.f = direct + share_ * late.f,
             .df = -direct * nu / variance + share_ * late.df,
             .ddf = direct * (nu * nu / variance - 1.0) / variance + share_ * late.ddf};
  if (is_difference) {
    const Ratios reference = with_excess(-nu, variance, mean_excess_);
    sum.f += share_ * reference.f;
    sum.df -= share_ * reference.df;
    sum.ddf += share_ * reference.ddf;
  }
  const double g = -sum.df / sum.f;
  const double G = g * g - sum.ddf / sum.f;
  // In the tail, and between the parts of the mixture, the density is flat or even widens the posterior (G <= 0), which
  // no Kalman update does. The mean stays exact; the variance ends where the innovation would look implausible.
  const double flattest = std::max(variance, kExplainedNis / (g * g));
  const double equivalent = G > 0.0 ? std::clamp(1.0 / G, variance, flattest) : flattest;
  return {g * equivalent, equivalent};
}

}  // namespace waymark::indoor_gps
