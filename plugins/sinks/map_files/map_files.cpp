// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "waymark/io/file_stems.hpp"
#include "waymark/io/output_file.hpp"
#include "waymark/plugin/sink.hpp"

namespace waymark::map_files {
namespace {

/// The best particle's maps in the formats of their own modules, at the end of the run.
class MapFiles : public Sink {
 public:
  explicit MapFiles(const Config&) {}

  void start(const RunInfo& info) override { out_dir_ = info.out_dir; }
  void write(const Snapshot&) override {}

  void finish(const Snapshot* last, const RunReport&) override {
    if (last == nullptr || !last->started()) return;
    FileStems stems = FileStems::of_results();
    for (const MapDescription& map : last->best_maps(MapDetail::with_files)) {
      const std::string stem = stems.of(map.module);
      for (const MapFile& file : map.files) write_file(out_dir_ / (stem + file.extension), file.content);
    }
  }

 private:
  std::filesystem::path out_dir_;
};

}  // namespace
}  // namespace waymark::map_files

WAYMARK_PLUGIN(waymark::Sink, waymark::map_files::MapFiles, "map_files", "1.0.0")
