// SPDX-License-Identifier: Apache-2.0
#include "late_signal.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace waymark::gnss {
namespace {

constexpr double kExplainedNis = 4.0;  // of what a reflection explains
constexpr double kWide = 25.0;         // a prior variance of so many τ² does not tell reflections from direct signals

/// Mills' ratio (1 − Φ(x))/φ(x).
double mills(double x) {
  constexpr double kContinued = 8.0;
  x = std::max(x, -35.0);  // beyond it the ratio only says that the Gaussian is negligible
  if (x < kContinued)
    return std::sqrt(0.5 * std::numbers::pi) * std::exp(0.5 * x * x) * std::erfc(x / std::numbers::sqrt2);
  double tail = x;  // Laplace's continued fraction
  for (int k = 30; k >= 1; --k) tail = x + k / tail;
  return 1.0 / tail;
}

}  // namespace

Moments LateSignal::moments() const {
  return {share * mean_excess, variance + share * (2.0 - share) * mean_excess * mean_excess};
}

Moments equivalent_noise(const LateSignal& noise, double nu, double prior) {
  const double tau = noise.mean_excess;
  if (noise.share <= 0.0) return {0.0, noise.variance};
  if (prior > kWide * tau * tau) return noise.moments();
  // Densities over the Gaussian one. The late part f_E solves τ f_E′ + f_E = N, which gives its derivatives.
  const double S = prior + noise.variance;
  const double s = std::sqrt(S);
  const double late = s / tau * mills(s / tau - nu / s);
  const double d_late = (1.0 - late) / tau;
  const double dd_late = (-nu / S - d_late) / tau;
  const double direct = 1.0 - noise.share;
  const double f = direct + noise.share * late;
  const double df = -direct * nu / S + noise.share * d_late;
  const double ddf = direct * (nu * nu / S - 1.0) / S + noise.share * dd_late;
  const double g = -df / f;
  const double G = g * g - ddf / f;
  const double flattest = std::max(S, kExplainedNis / (g * g));
  const double equivalent = G > 0.0 ? std::clamp(1.0 / G, S, flattest) : flattest;
  return {nu - g * equivalent, equivalent - prior};
}

}  // namespace waymark::gnss
