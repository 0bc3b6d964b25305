// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "waymark/interface/snapshot.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark {

/// The figures of the maps over time, as CSV: a row per figure, every so many seconds of the log and at its end.
class MapFiguresLog {
 public:
  MapFiguresLog(const std::filesystem::path& file, Duration interval) : file_(file), interval_(interval) {
    file_.write("t_s,map,figure,value\n");
  }

  void look(const Snapshot& snapshot) {
    if (last_ && snapshot.stamp() < *last_ + interval_) return;
    write(snapshot);
  }

  /// `last` is null if there was nothing.
  void finish(const Snapshot* last) {
    if (last != nullptr && last_ && last->stamp() > *last_) write(*last);
    file_.commit();
  }

 private:
  void write(const Snapshot& snapshot) {
    last_ = snapshot.stamp();
    for (const MapDescription& map : snapshot.best_maps(MapDetail::summary)) {
      for (const MapFigure& figure : map.figures) {
        file_.write(fmt::format("{},{},{},{}\n", format_time(*last_), quoted(map.module), quoted(figure.name),
                                std::isfinite(figure.value) ? fmt::format("{}", figure.value) : ""));
      }
    }
  }

  /// Names come from the YAML and from plugins: a comma or a quote in one must not tear a row.
  static std::string quoted(const std::string& name) {
    if (name.find_first_of(",\"\r\n") == std::string::npos) return name;
    std::string text = "\"";
    for (const char c : name) text.append(c == '"' ? 2 : 1, c);
    return text + '"';
  }

  OutputFile file_;
  Duration interval_;
  std::optional<Time> last_;
};

}  // namespace waymark
