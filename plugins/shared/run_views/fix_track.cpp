// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/run_views/fix_track.hpp"

#include <GeographicLib/LocalCartesian.hpp>
#include <cmath>

#include "waymark/interface/payloads.hpp"

namespace waymark::run_views {
namespace {

std::optional<FixTrack::Kind> kind_of(Fate fate) {
  switch (fate) {
    case Fate::fused:
      return FixTrack::Kind::used;
    case Fate::gated:
      return FixTrack::Kind::rejected;
    case Fate::held_out:
      return FixTrack::Kind::held_out;
    default:
      return std::nullopt;
  }
}

}  // namespace

void FixTrack::add(const Snapshot& snapshot) {
  const Measurement& measurement = snapshot.measurement();
  const auto kind = kind_of(snapshot.fate());
  if (!kind || measurement.payload == nullptr || measurement.payload->type() != GnssFix::kType) return;
  const auto& fix = measurement.as<GnssFix>();
  Fixes& fixes = fixes_[static_cast<std::size_t>(*kind)];
  if (fix.p_map_antenna.head<2>().allFinite()) {
    fixes.add({{fix.p_map_antenna.x(), fix.p_map_antenna.y(), 0.0}, false});
  } else if (std::abs(fix.latitude_deg) <= 90.0 && std::abs(fix.longitude_deg) <= 180.0) {
    fixes.add({{fix.latitude_deg, fix.longitude_deg, fix.height_m}, true});
  }
}

std::vector<Eigen::Vector2d> FixTrack::positions(Kind kind, const std::optional<Datum>& datum) const {
  GeographicLib::LocalCartesian frame;
  if (datum) frame.Reset(datum->latitude_deg, datum->longitude_deg, datum->height_m);
  std::vector<Eigen::Vector2d> out;
  for (const Fix& fix : of(kind).elements()) {
    const Eigen::Vector3d& p = fix.position;
    if (!fix.is_geodetic) {
      out.emplace_back(p.x(), p.y());
    } else if (datum) {
      Eigen::Vector3d local;
      frame.Forward(p.x(), p.y(), std::isfinite(p.z()) ? p.z() : datum->height_m, local.x(), local.y(), local.z());
      out.emplace_back(local.x(), local.y());
    }
  }
  return out;
}

}  // namespace waymark::run_views
