// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "track.hpp"
#include "waymark/io/xml_text.hpp"

namespace waymark::geo_track {

std::string to_gpx(const Track& track) {
  std::string out =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<gpx version=\"1.1\" creator=\"waymark\" xmlns=\"http://www.topografix.com/GPX/1/1\">\n";
  for (const Mark& mark : track.marks) {
    out += fmt::format("<wpt lat=\"{:.8f}\" lon=\"{:.8f}\"><name>{}</name></wpt>\n", mark.place.latitude_deg,
                       mark.place.longitude_deg, xml_text(mark.name));
  }
  out += fmt::format("<trk><name>{}</name>\n", xml_text(track.name));
  for (const auto& piece : track.pieces) {
    out += "<trkseg>\n";
    for (const TrackPoint& point : piece) {
      out +=
          fmt::format("<trkpt lat=\"{:.8f}\" lon=\"{:.8f}\"><ele>{:.3f}</ele><time>{}</time></trkpt>\n",
                      point.place.latitude_deg, point.place.longitude_deg, point.place.height_m, iso_time(point.stamp));
    }
    out += "</trkseg>\n";
  }
  return out + "</trk>\n</gpx>\n";
}

}  // namespace waymark::geo_track
