// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/map_formats/landmark_list.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <iterator>

#include "waymark/config/config.hpp"

namespace waymark::map_formats {

namespace {

constexpr double kFarthestPlace = 1e8;   // m; beyond, doubles are too coarse for a place
constexpr double kSurveyedSigma = 0.01;  // m, where no covariance is given

Eigen::Matrix3d read_covariance(const Config& config, bool of_position_only, const Eigen::Matrix3d& fallback) {
  const Config::Key key =
      of_position_only
          ? Config::Key{"covariance_floor_m2", "m²", "lower bound of its covariance: ee, en, nn", "1 cm each"}
          : Config::Key{"covariance_m2", "m²", "covariance of (east, north, radius): ee, en, nn, er, nr, rr",
                        "1 cm each"};
  if (!config.has(key.name)) return fallback;
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
    config.fail(key.name, fmt::format("is not a covariance: its smallest eigenvalue is {:.3g}", least));
  }
  return P;
}

std::vector<float> read_signature(const Config& config) {
  if (!config.has("signature")) return {};
  const std::vector<double> bins = config.numbers({"signature", "", "its bins, which add up to 1", "none"});
  if (bins.empty() || bins.size() > LandmarkEntry::kMaxBins) {
    config.fail("signature", fmt::format("{} bins; 1 to {} are possible", bins.size(), LandmarkEntry::kMaxBins));
  }
  std::vector<float> signature;
  double sum = 0.0;
  for (std::size_t b = 0; b < bins.size(); ++b) {
    if (!(bins[b] >= 0.0)) config.fail("signature", fmt::format("bin {} is {}, below zero", b, bins[b]));
    signature.push_back(static_cast<float>(bins[b]));
    sum += bins[b];
  }
  if (std::abs(sum - 1.0) > 1e-3) config.fail("signature", fmt::format("its bins add up to {}, not to 1", sum));
  return signature;
}

LandmarkEntry read_landmark(const Config& config) {
  LandmarkEntry landmark;
  landmark.place = config.place();
  // Not with commas: what they begin must be finished, and reading may throw.
  landmark.mean = Eigen::Vector3d(
      config.number_in({"east_m", "m", "its middle in the map, towards the east"}, -kFarthestPlace, kFarthestPlace),
      config.number_in({"north_m", "m", "its middle in the map, towards the north"}, -kFarthestPlace, kFarthestPlace),
      config.non_negative({"radius_m", "m", "its radius"}, 0.0));
  const double variance = kSurveyedSigma * kSurveyedSigma;
  landmark.P = read_covariance(config, false, variance * Eigen::Matrix3d::Identity());
  landmark.P_floor =
      read_covariance(config, true, Eigen::Vector3d(variance, variance, 0.0).asDiagonal()).topLeftCorner<2, 2>();
  landmark.signature = read_signature(config);
  constexpr std::int64_t kMost = 1'000'000'000;
  landmark.signature_views = static_cast<std::int32_t>(
      config.integer_in({"signature_views", "", "number of views of its signature", "1 with a signature, else 0"}, 0,
                        kMost, landmark.signature.empty() ? 0 : 1));
  landmark.identity =
      static_cast<std::int32_t>(config.integer_in({"identity", "as read by a device; -1: unknown"}, -1, kMost, -1));
  if (config.has("log_odds")) {
    landmark.log_odds =
        static_cast<float>(config.number({"log_odds", "", "log-odds of its existence", "`existence.log_odds_max`"}));
  }
  if (config.has("sightings")) {
    landmark.sightings = static_cast<std::int32_t>(
        config.integer_in({"sightings", "", "number of sightings", "`existence.min_observations`"}, 0, kMost, 0));
  }
  return landmark;
}

}  // namespace

std::vector<LandmarkEntry> read_landmark_list(const std::filesystem::path& file) {
  const Config config = Config::load(file);
  if (const std::int64_t version = config.integer({"version", "version of the format"});
      version != kLandmarkListVersion) {
    config.fail("version", fmt::format("{} is not {}, the only one that is known", version, kLandmarkListVersion));
  }
  std::vector<LandmarkEntry> landmarks;
  std::size_t bins = 0;
  for (const Config& item :
       config.items({"landmarks", "one landmark each; only `east_m` and `north_m` are required"})) {
    LandmarkEntry landmark = read_landmark(item);
    if (!landmark.signature.empty()) {
      if (bins == 0) bins = landmark.signature.size();
      if (landmark.signature.size() != bins) {
        item.fail("signature",
                  fmt::format("{} bins, but the landmarks before have {}", landmark.signature.size(), bins));
      }
    }
    landmarks.push_back(std::move(landmark));
  }
  config.reject_unread();
  return landmarks;
}

std::string landmark_list_text(const std::vector<LandmarkEntry>& landmarks) {
  std::string text = fmt::format(
      "# Landmarks of a feature map (waymark); covariances of east, north, radius: ee, en, nn, er, nr, rr.\n"
      "version: {}\nlandmarks:{}\n",
      kLandmarkListVersion, landmarks.empty() ? " []" : "");
  auto out = std::back_inserter(text);
  for (const LandmarkEntry& landmark : landmarks) {
    const Eigen::Matrix3d& P = landmark.P;
    const Eigen::Matrix2d& floor = landmark.P_floor;
    fmt::format_to(out,
                   "  - {{ east_m: {}, north_m: {}, radius_m: {}, covariance_m2: [{}, {}, {}, {}, {}, {}], "
                   "covariance_floor_m2: [{}, {}, {}]",
                   landmark.mean.x(), landmark.mean.y(), landmark.mean.z(), P(0, 0), P(0, 1), P(1, 1), P(0, 2), P(1, 2),
                   P(2, 2), floor(0, 0), floor(0, 1), floor(1, 1));
    if (landmark.log_odds) fmt::format_to(out, ", log_odds: {}", *landmark.log_odds);
    if (landmark.sightings) fmt::format_to(out, ", sightings: {}", *landmark.sightings);
    if (landmark.identity >= 0) fmt::format_to(out, ", identity: {}", landmark.identity);
    if (!landmark.signature.empty()) {
      fmt::format_to(out, ", signature_views: {}, signature: [{}]", landmark.signature_views,
                     fmt::join(landmark.signature, ", "));
    }
    fmt::format_to(out, " }}\n");
  }
  return text;
}

void move_landmark(const Pose& T_to_from, LandmarkEntry& landmark) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = T_to_from.q.toRotationMatrix().topLeftCorner<2, 2>();
  landmark.mean.head<2>() = (T_to_from * Eigen::Vector3d(landmark.mean.x(), landmark.mean.y(), 0.0)).head<2>();
  landmark.P = (turn * landmark.P * turn.transpose()).eval();
  landmark.P_floor = (turn.topLeftCorner<2, 2>() * landmark.P_floor * turn.topLeftCorner<2, 2>().transpose()).eval();
}

}  // namespace waymark::map_formats
