// SPDX-License-Identifier: Apache-2.0
// What a map shows of itself, for sinks and other readers.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "waymark/base/time.hpp"
#include "waymark/math/pose.hpp"

namespace waymark {

/// A landmark for sinks.
struct LandmarkView {
  std::int64_t id = 0;                              ///< stable within one particle's ancestry
  Eigen::Vector2d p_map = Eigen::Vector2d::Zero();  ///< east, north [m]
  double radius_m = 0.0;                            ///< NaN if the map has none
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();      ///< covariance of (east, north, radius)
  double existence = 0.0;                           ///< probability, 0..1
  int sightings = 0;
  bool confirmed = false;
  std::uint64_t birth = 0;  ///< names it in the maps of all particles; 0: it has no name
  /// Covariance of (east, north) given the path of the best particle. Set by the host, which puts the marginal one into
  /// `P` where it has it.
  Eigen::Matrix2d P_conditional = Eigen::Matrix2d::Zero();
};

/// A detection that was fused into a landmark, for scores of the data association.
struct Sighting {
  Time stamp{};
  Eigen::Vector2d p_base = Eigen::Vector2d::Zero();  ///< its position in the base frame [m]
  std::int64_t landmark = -1;                        ///< `LandmarkView::id`, in this ancestry
  bool is_first = false;                             ///< it created that landmark
};

/// A figure of a map, for reports: "merged", 3.
struct MapFigure {
  std::string name;
  double value = 0.0;
};

/// A grid of square cells seen from above, for sinks.
struct GridView {
  static constexpr std::uint8_t kUnknown = 255;

  Pose T_map_grid;            ///< the lower left corner of the first cell; x along the rows
  double resolution_m = 0.0;  ///< side of a cell
  int width = 0;              ///< cells in a row
  int height = 0;             ///< rows
  /// Row by row from the lower left: probability of being occupied in percent, 0..100, or kUnknown.
  std::vector<std::uint8_t> cells = {};
};

/// A map in the file format of its module, for other programs and for later runs.
struct MapFile {
  std::string extension;  ///< ".bt"; the host puts the map's name before it
  std::string content;    ///< all bytes of the file
  /// Where the coordinates of the file lie on the Earth; the identity if its format has a place for that.
  Pose T_enu_file = {};
};

/// Content of a particle's map, for sinks.
struct MapDescription {
  std::string module;  ///< name of the map in the YAML
  std::vector<LandmarkView> landmarks;
  std::vector<MapFigure> figures = {};
  std::vector<Sighting> sightings = {};  ///< of the particle and its ancestors, if the map keeps them
  std::optional<GridView> grid = {};     ///< of a dense map; only on request
  /// Occupancy over the maps of all particles (`mix_grids`); only on request.
  std::optional<GridView> mixture = {};
  std::vector<MapFile> files = {};  ///< only on request
};

}  // namespace waymark
