// SPDX-License-Identifier: Apache-2.0
#include "map_check.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <set>

namespace waymark::testing {

namespace {

template <class T>
void append(std::string& out, const T& value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

template <class M>
void append_matrix(std::string& out, const M& m) {
  out.append(reinterpret_cast<const char*>(m.data()), sizeof(double) * static_cast<std::size_t>(m.size()));
}

bool symmetric(const Eigen::Matrix3d& m) {
  return (m - m.transpose()).cwiseAbs().maxCoeff() <= 1e-9 * std::max(m.cwiseAbs().maxCoeff(), 1e-300);
}

bool positive_semi_definite(const Eigen::Matrix3d& m) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(m, Eigen::EigenvaluesOnly);
  const double largest = solver.eigenvalues().cwiseAbs().maxCoeff();
  return solver.eigenvalues().minCoeff() >= -1e-9 * largest;
}

}  // namespace

std::string numbers_of(const Refinement& refinement) {
  std::string out;
  append_matrix(out, refinement.information);
  append_matrix(out, refinement.gradient);
  append(out, refinement.log_evidence);
  return out;
}

std::string description_of(const ParticleMap& map) {
  MapDescription description;
  map.describe(description);
  std::string out;
  for (const LandmarkView& landmark : description.landmarks) {
    append(out, landmark.id);
    append_matrix(out, landmark.p_map);
    append(out, landmark.radius_m);
    append_matrix(out, landmark.P);
    append(out, landmark.existence);
    append(out, landmark.sightings);
    append(out, landmark.confirmed);
  }
  if (const std::optional<GridView> grid = map.grid()) {
    append_matrix(out, grid->T_map_grid.p);
    append(out, grid->resolution_m);
    append(out, grid->width);
    append(out, grid->height);
    out.append(grid->cells.begin(), grid->cells.end());
  }
  for (const MapFile& file : map.files(Pose{})) out.append(file.extension).append(file.content);
  return out;
}

void check_refinement(const Refinement& refinement, std::string_view where, Findings& findings) {
  findings.require(std::isfinite(refinement.log_evidence), "the log evidence is not finite", where);
  findings.require(refinement.gradient.allFinite(), "the gradient is not finite", where);
  if (!refinement.information.allFinite()) {
    findings.add("the information is not finite", where);
    return;
  }
  findings.require(symmetric(refinement.information), "the information is not symmetric", where);
  findings.require(positive_semi_definite(refinement.information), "the information is not positive semi-definite",
                   where);
}

void check_description(const ParticleMap& map, Findings& findings) {
  MapDescription description;
  map.describe(description);
  if (const std::optional<GridView> seen = map.grid()) {
    const GridView& grid = *seen;
    findings.require(grid.T_map_grid.p.allFinite() && grid.resolution_m > 0.0 && grid.width > 0 && grid.height > 0,
                     "a grid is at no finite place, or has no size");
    findings.require(grid.cells.size() == static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height),
                     "a grid has another number of cells than width times height");
    findings.require(
        std::ranges::all_of(grid.cells, [](std::uint8_t c) { return c <= 100 || c == GridView::kUnknown; }),
        "a cell of a grid is neither a percentage nor unknown");
  }
  std::set<std::int64_t> ids;
  for (const LandmarkView& landmark : description.landmarks) {
    const std::string where = "landmark " + std::to_string(landmark.id);
    findings.require(ids.insert(landmark.id).second, "two landmarks have one id", where);
    findings.require(landmark.p_map.allFinite() && !std::isinf(landmark.radius_m), "a landmark is at no finite place",
                     where);
    findings.require(landmark.existence >= 0.0 && landmark.existence <= 1.0, "an existence is not a probability",
                     where);
    findings.require(landmark.sightings >= 0, "a landmark has negative sightings", where);
    const bool covariance = landmark.P.allFinite() && symmetric(landmark.P) && positive_semi_definite(landmark.P);
    findings.require(covariance, "a landmark's covariance is not positive semi-definite", where);
  }
}

}  // namespace waymark::testing
