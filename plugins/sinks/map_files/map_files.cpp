// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/map_formats/write_maps.hpp"
#include "waymark/plugin/sink.hpp"

namespace waymark::map_files {
namespace {

/// The best particle's maps in the formats of their own modules and a manifest of them, at the end of the run.
class MapFiles : public Sink {
 public:
  explicit MapFiles(const Config&) {}

  void start(const RunInfo& info) override { out_dir_ = info.out_dir; }
  void write(const Snapshot&) override {}

  void finish(const Snapshot* last, const RunReport&) override {
    if (last == nullptr || !last->started()) return;
    map_formats::write_maps(*last, out_dir_, FileStems::of_results(), Belongs::to_run);
  }

 private:
  std::filesystem::path out_dir_;
};

}  // namespace
}  // namespace waymark::map_files

WAYMARK_PLUGIN(waymark::Sink, waymark::map_files::MapFiles, "map_files", "1.0.0")
