// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "waymark/interface/snapshot.hpp"
#include "waymark/io/csv_field.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark::diagnostics {

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
        file_.write(fmt::format("{},{},{},{}\n", format_time(*last_), csv_field(map.module), csv_field(figure.name),
                                std::isfinite(figure.value) ? fmt::format("{}", figure.value) : ""));
      }
    }
  }

  OutputFile file_;
  Duration interval_;
  std::optional<Time> last_;
};

}  // namespace waymark::diagnostics
