// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "track.hpp"
#include "waymark/io/xml_text.hpp"

namespace waymark::geo_track {

std::string to_kml(const Track& track) {
  std::string out = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\">\n<Document>\n"
      "<name>{0}</name>\n"
      "<Style id=\"path\"><LineStyle><color>ffff4010</color><width>3</width></LineStyle></Style>\n"
      "<Placemark><name>{0}</name><styleUrl>#path</styleUrl>\n<MultiGeometry>\n",
      xml_text(track.name));
  for (const auto& piece : track.pieces) {
    out += "<LineString><tessellate>1</tessellate><coordinates>\n";
    for (const TrackPoint& point : piece) {
      out += fmt::format("{:.8f},{:.8f},{:.3f}\n", point.place.longitude_deg, point.place.latitude_deg,
                         point.place.height_m);
    }
    out += "</coordinates></LineString>\n";
  }
  out += "</MultiGeometry></Placemark>\n";
  for (const Mark& mark : track.marks) {
    out +=
        fmt::format("<Placemark><name>{}</name><Point><coordinates>{:.8f},{:.8f}</coordinates></Point></Placemark>\n",
                    xml_text(mark.name), mark.place.longitude_deg, mark.place.latitude_deg);
  }
  return out + "</Document>\n</kml>\n";
}

}  // namespace waymark::geo_track
