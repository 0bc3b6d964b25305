// SPDX-License-Identifier: Apache-2.0
#include "landmark_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <iterator>
#include <vector>

#include "waymark/config.hpp"

namespace waymark {

namespace {

constexpr std::int64_t kVersion = 1;
constexpr double kSurveyedSigma = 0.01;  // m, where nothing else is said

Eigen::Matrix3d read_covariance(const Config& config, bool of_position_only, const Eigen::Matrix3d& fallback) {
  const char* key = of_position_only ? "covariance_floor_m2" : "covariance_m2";
  if (!config.has(key)) return fallback;
  const std::vector<double> c = config.numbers(key, of_position_only ? 3 : 6);
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
  P.topLeftCorner<2, 2>() << c[0], c[1], c[1], c[2];
  if (!of_position_only) {
    P.row(2) << c[3], c[4], c[5];
    P.col(2) << c[3], c[4], c[5];
  }
  const double least = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(P, Eigen::EigenvaluesOnly).eigenvalues().x();
  constexpr double kRounding = 1e-9;
  if (least < -kRounding * P.trace()) {
    config.fail(key, fmt::format("is no covariance: its smallest eigenvalue is {:.3g}", least));
  }
  return P;
}

Signature read_signature(const Config& config) {
  Signature signature;
  if (!config.has("signature")) return signature;
  const std::vector<double> bins = config.numbers("signature");
  if (bins.empty() || bins.size() > Signature::kMaxBins) {
    config.fail("signature", fmt::format("{} bins; 1 to {} are possible", bins.size(), Signature::kMaxBins));
  }
  signature = Signature::uniform(bins.size());
  double sum = 0.0;
  for (std::size_t b = 0; b < bins.size(); ++b) {
    if (!(bins[b] >= 0.0)) config.fail("signature", fmt::format("bin {} is {}, below zero", b, bins[b]));
    signature[b] = static_cast<float>(bins[b]);
    sum += bins[b];
  }
  if (std::abs(sum - 1.0) > 1e-3) config.fail("signature", fmt::format("its bins add up to {}, not to 1", sum));
  return signature;
}

Landmark read_landmark(const Config& config, const FeatureMapSettings& settings) {
  Landmark landmark;
  // Not with commas: what they begin must be finished, and reading may throw.
  landmark.mean =
      Eigen::Vector3d(config.number("east_m"), config.number("north_m"), config.non_negative("radius_m", 0.0));
  const double variance = kSurveyedSigma * kSurveyedSigma;
  landmark.P = read_covariance(config, false, variance * Eigen::Matrix3d::Identity());
  landmark.P_floor =
      read_covariance(config, true, Eigen::Vector3d(variance, variance, 0.0).asDiagonal()).topLeftCorner<2, 2>();
  landmark.signature = read_signature(config);
  constexpr std::int64_t kMost = 1'000'000'000;
  landmark.signature_views =
      static_cast<std::int32_t>(config.integer_in("signature_views", 0, kMost, landmark.signature.empty() ? 0 : 1));
  landmark.identity = static_cast<std::int32_t>(config.integer_in("identity", -1, kMost, -1));
  landmark.log_odds = static_cast<float>(config.number("log_odds", settings.existence.log_odds_max));
  landmark.sightings =
      static_cast<std::int32_t>(config.integer_in("sightings", 0, kMost, settings.existence.min_observations));
  return landmark;
}

}  // namespace

std::string landmark_file(const LandmarkStore& landmarks, const Pose& T_enu_map) {
  std::string text = fmt::format(
      "# Landmarks of a feature map (waymark); covariances of east, north, radius: ee, en, nn, er, nr, rr.\n"
      "version: {}\nlandmarks:{}\n",
      kVersion, landmarks.size() == 0 ? " []" : "");
  auto out = std::back_inserter(text);
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = T_enu_map.q.toRotationMatrix().topLeftCorner<2, 2>();
  landmarks.for_all([&](const Landmark& landmark) {
    const Eigen::Vector3d p = T_enu_map * Eigen::Vector3d(landmark.mean.x(), landmark.mean.y(), 0.0);
    const Eigen::Matrix3d P = turn * landmark.P * turn.transpose();
    const Eigen::Matrix2d floor =
        turn.topLeftCorner<2, 2>() * landmark.P_floor * turn.topLeftCorner<2, 2>().transpose();
    fmt::format_to(out,
                   "  - {{ east_m: {}, north_m: {}, radius_m: {}, covariance_m2: [{}, {}, {}, {}, {}, {}], "
                   "covariance_floor_m2: [{}, {}, {}], log_odds: {}, sightings: {}",
                   p.x(), p.y(), landmark.mean.z(), P(0, 0), P(0, 1), P(1, 1), P(0, 2), P(1, 2), P(2, 2), floor(0, 0),
                   floor(0, 1), floor(1, 1), landmark.log_odds, landmark.sightings);
    if (landmark.identity >= 0) fmt::format_to(out, ", identity: {}", landmark.identity);
    if (!landmark.signature.empty()) {
      fmt::format_to(out, ", signature_views: {}, signature: [{}]", landmark.signature_views,
                     fmt::join(landmark.signature, ", "));
    }
    fmt::format_to(out, " }}\n");
  });
  return text;
}

LandmarkStore read_landmark_file(const std::filesystem::path& file, const FeatureMapSettings& settings) {
  const Config config = Config::load(file);
  if (const std::int64_t version = config.integer("version"); version != kVersion) {
    config.fail("version", fmt::format("{} is not {}, the only one that is known", version, kVersion));
  }
  LandmarkStore landmarks;
  std::size_t bins = 0;
  for (const Config& item : config.items("landmarks")) {
    const Landmark landmark = read_landmark(item, settings);
    if (!landmark.signature.empty()) {
      if (bins == 0) bins = landmark.signature.size();
      if (landmark.signature.size() != bins) {
        item.fail("signature",
                  fmt::format("{} bins, but the landmarks before have {}", landmark.signature.size(), bins));
      }
      if (const std::size_t expected = settings.signature_bins(); expected != 0 && bins != expected) {
        item.fail("signature", fmt::format("{} bins, but those of this configuration have {}", bins, expected));
      }
    }
    landmarks.add(landmark);
  }
  config.reject_unread();
  return landmarks;
}

}  // namespace waymark
