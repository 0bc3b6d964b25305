// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "track.hpp"

namespace waymark::geo_track {
namespace {

std::string json_text(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += static_cast<unsigned char>(c) < 0x20 ? '?' : c;
  }
  return result + '"';
}

}  // namespace

std::string to_geojson(const Track& track) {
  std::string lines;
  std::string times;
  for (const auto& piece : track.pieces) {
    std::string line;
    std::string of_line;
    for (const TrackPoint& point : piece) {
      const char* before = line.empty() ? "" : ",\n";
      line += fmt::format("{}[{:.8f},{:.8f},{:.3f}]", before, point.place.longitude_deg, point.place.latitude_deg,
                          point.place.height_m);
      of_line += fmt::format("{}\"{}\"", before, iso_time(point.stamp));
    }
    const char* before = lines.empty() ? "" : ",\n";
    lines += fmt::format("{}[{}]", before, line);
    times += fmt::format("{}[{}]", before, of_line);
  }
  std::string out = fmt::format(
      "{{\"type\":\"FeatureCollection\",\"features\":[\n{{\"type\":\"Feature\",\"properties\":{{\"name\":{},\"times\":["
      "{}]}},"
      "\n\"geometry\":{{\"type\":\"MultiLineString\",\"coordinates\":[{}]}}}}",
      json_text(track.name), times, lines);
  for (const Mark& mark : track.marks) {
    out += fmt::format(
        ",\n{{\"type\":\"Feature\",\"properties\":{{\"name\":{}}},\"geometry\":{{\"type\":\"Point\",\"coordinates\":"
        "[{:.8f},{:.8f}]}}}}",
        json_text(mark.name), mark.place.longitude_deg, mark.place.latitude_deg);
  }
  return out + "\n]}\n";
}

}  // namespace waymark::geo_track
