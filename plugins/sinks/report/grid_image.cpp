// SPDX-License-Identifier: Apache-2.0
#include "grid_image.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "waymark/base/error.hpp"

namespace waymark::report {
namespace {

constexpr int kMostPixels = 2000;

std::string base64(const std::vector<uchar>& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t block = static_cast<std::uint32_t>(bytes[i]) << 16;
    if (count > 1) block |= static_cast<std::uint32_t>(bytes[i + 1]) << 8;
    if (count > 2) block |= bytes[i + 2];
    text += kDigits[block >> 18 & 63];
    text += kDigits[block >> 12 & 63];
    text += count > 1 ? kDigits[block >> 6 & 63] : '=';
    text += count > 2 ? kDigits[block & 63] : '=';
  }
  return text;
}

/// Grey and opacity of a block of cells: an occupied cell counts more than a free one, or walls would vanish.
cv::Vec2b shade(const GridView& grid, int first_column, int first_row, int side) {
  int most = -1;
  for (int row = first_row; row < std::min(first_row + side, grid.height); ++row) {
    for (int column = first_column; column < std::min(first_column + side, grid.width); ++column) {
      const auto place = static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.width);
      const std::uint8_t cell = grid.cells[place + static_cast<std::size_t>(column)];
      if (cell != GridView::kUnknown) most = std::max<int>(most, cell);
    }
  }
  if (most < 0) return {0, 0};
  // What is more likely free than not is free to the eye: probabilities between are noise of the sensor.
  constexpr int kFree = 238;
  constexpr int kOccupied = 40;
  const double share = std::clamp((most - 35) / 40.0, 0.0, 1.0);
  return {static_cast<uchar>(std::lround(kFree + share * (kOccupied - kFree))), 255};
}

}  // namespace

GridImage picture_of(const GridView& grid) {
  const int side = std::max(1, (std::max(grid.width, grid.height) + kMostPixels - 1) / kMostPixels);
  const int columns = (grid.width + side - 1) / side;
  const int rows = (grid.height + side - 1) / side;
  // OpenCV writes grey with opacity as four channels only.
  cv::Mat image(std::max(rows, 1), std::max(columns, 1), CV_8UC4, cv::Scalar::all(0));
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const cv::Vec2b cell = shade(grid, column * side, row * side, side);
      image.at<cv::Vec4b>(rows - 1 - row, column) = {cell[0], cell[0], cell[0], cell[1]};
    }
  }
  std::vector<uchar> bytes;
  bool done = false;
  try {
    done = cv::imencode(".png", image, bytes, {cv::IMWRITE_PNG_COMPRESSION, 6});
  } catch (const cv::Exception& error) {
    throw Error(std::string("report: the grid cannot be encoded as PNG: ") + error.what());
  }
  if (!done) throw Error("report: the grid cannot be encoded as PNG");
  return {base64(bytes), columns * side * grid.resolution_m, rows * side * grid.resolution_m};
}

}  // namespace waymark::report
