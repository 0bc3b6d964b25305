// SPDX-License-Identifier: Apache-2.0
// What looking at one scan's candidates in one VGA image costs, once per scan, whatever the number of particles.
#include <benchmark/benchmark.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include "tests/unit/map_modules/feature_map/camera_bench.hpp"

namespace waymark::feature_map {
namespace {

using feature_map_test::camera_settings;
using feature_map_test::CameraScene;
using feature_map_test::kBluePaint;

/// `count` cylinders side by side, 4 to 8 m ahead, all in the image.
CameraScene row_of(int count) {
  CameraScene scene;
  for (int i = 0; i < count; ++i) {
    const double bearing = count > 1 ? -0.45 + 0.9 * i / (count - 1) : 0.0;
    const double range = i % 2 == 0 ? 4.0 : 8.0;
    scene.things.push_back({{range * std::cos(bearing), range * std::sin(bearing)}, 0.15, kBluePaint});
  }
  return scene;
}

/// A new image for every scan: decoding, edges, radii and histograms.
void look(benchmark::State& state, Image::Encoding encoding) {
  const CameraScene scene = row_of(static_cast<int>(state.range(0)));
  const cv::Mat bgr = scene.picture();
  Measurement image = scene.image(bgr);
  if (encoding == Image::Encoding::compressed) {
    auto file = std::make_shared<Image>();
    file->encoding = encoding;
    cv::imencode(".jpg", bgr, file->data);
    image.payload = std::move(file);
  }
  const FeatureMapSettings settings = camera_settings();
  const LaserScan scan = scene.scan();
  CameraExtraction camera(scene.intrinsics, scene.T_base_camera, settings.camera.value(), settings.noise.range);
  std::size_t found = 0;
  for (auto _ : state) {
    ++image.sequence;
    ScanView view = view_of(scan, scene.T_base_scanner, settings.extraction);
    std::vector<Candidate> candidates = examine(view, settings.extraction);
    const ImageLook seen = camera.look(&image, image.stamp, {}, scene.T_base_scanner, candidates);
    const auto observation = observe(scan, std::move(view), candidates, &seen, scene.T_base_scanner, settings);
    found = observation.detections.size();
    benchmark::DoNotOptimize(found);
  }
  state.counters["detections"] = static_cast<double>(found);
}
BENCHMARK_CAPTURE(look, pixels, Image::Encoding::bgr8)->Arg(1)->Arg(4)->Arg(12)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(look, jpeg, Image::Encoding::compressed)->Arg(1)->Arg(4)->Arg(12)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace waymark::feature_map
