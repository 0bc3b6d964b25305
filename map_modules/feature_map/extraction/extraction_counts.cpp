// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/extraction/extraction_counts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace waymark::feature_map {

namespace {

constexpr std::array<const char*, kImageStates> kImageNames = {
    "images_used", "images_missing", "images_undecodable", "images_wrong_size", "images_dark", "images_overexposed"};

bool is_of_camera(std::size_t verdict) {
  return verdict == static_cast<std::size_t>(Verdict::no_edges) ||
         verdict == static_cast<std::size_t>(Verdict::off_image);
}

}  // namespace

void ExtractionCounts::add(const std::vector<Candidate>& candidates) {
  for (const Candidate& candidate : candidates) ++candidates_[static_cast<std::size_t>(candidate.verdict)];
}

void ExtractionCounts::add(const ImageLook& look, const std::vector<Candidate>& candidates) {
  ++images_[static_cast<std::size_t>(look.image.state)];
  if (look.image.state != ImageState::used) return;
  const auto accepted = std::ranges::count(candidates, Verdict::accepted, &Candidate::verdict);
  const auto shown = std::ranges::count(look.looks, true, &CandidateLook::has_edges);
  not_shown_ += static_cast<std::uint64_t>(accepted - shown);
}

void ExtractionCounts::describe(bool with_camera, std::vector<MapFigure>& figures) const {
  for (std::size_t i = 0; i < kVerdicts; ++i) {
    if (!with_camera && is_of_camera(i)) continue;
    figures.push_back(
        {fmt::format("candidates_{}", name_of(static_cast<Verdict>(i))), static_cast<double>(candidates_[i])});
  }
  if (!with_camera) return;
  figures.push_back({"candidates_accepted_off_image", static_cast<double>(not_shown_)});
  for (std::size_t i = 0; i < kImageStates; ++i) figures.push_back({kImageNames[i], static_cast<double>(images_[i])});
}

}  // namespace waymark::feature_map
