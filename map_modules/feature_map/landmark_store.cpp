// SPDX-License-Identifier: Apache-2.0
#include "landmark_store.hpp"

#include <algorithm>
#include <string>

#include "waymark/error.hpp"

namespace waymark {

namespace {

// A chunk that would grow beyond this holds no neighbours any more, and its box would be hit by every search.
constexpr double kMaxChunkExtent = 30.0;  // [m]

}  // namespace

std::int64_t LandmarkStore::add(Landmark landmark) {
  Directory& directory = directory_.write();
  const Eigen::Vector2d p = landmark.mean.head<2>();
  Entry* best = nullptr;
  double best_extent = kMaxChunkExtent;
  for (Entry& entry : directory.entries) {
    if (entry.used == kChunkSize) continue;
    Box grown = entry.box;
    grown.include(p);
    const double extent = (grown.high - grown.low).maxCoeff();
    if (extent < best_extent) {
      best_extent = extent;
      best = &entry;
    }
  }
  if (best == nullptr) {
    directory.entries.emplace_back();
    best = &directory.entries.back();
  }
  auto& places = best->chunk.write().places;
  landmark.id = directory.next_id++;
  *std::find_if(places.begin(), places.end(), [](const Landmark& l) { return l.id < 0; }) = landmark;
  best->box.include(p);
  ++best->used;
  ++directory.count;
  return landmark.id;
}

void LandmarkStore::write(LandmarkRef ref, const Landmark& landmark) {
  Entry& entry = directory_.write().entries[static_cast<std::size_t>(ref.chunk)];
  Landmark& place = entry.chunk.write().places[static_cast<std::size_t>(ref.place)];
  const std::int64_t id = place.id;
  place = landmark;
  place.id = id;
  entry.box.include(landmark.mean.head<2>());
}

void LandmarkStore::erase(LandmarkRef ref) {
  Directory& directory = directory_.write();
  Entry& entry = directory.entries[static_cast<std::size_t>(ref.chunk)];
  auto& places = entry.chunk.write().places;
  places[static_cast<std::size_t>(ref.place)].id = -1;
  --entry.used;
  --directory.count;
  entry.box = Box{};
  for (const Landmark& landmark : places) {
    if (landmark.id >= 0) entry.box.include(landmark.mean.head<2>());
  }
}

int LandmarkStore::chunks_not_shared_with(const LandmarkStore& other) const {
  int count = 0;
  const auto& mine = directory_->entries;
  const auto& theirs = other.directory_->entries;
  for (std::size_t i = 0; i < mine.size(); ++i)
    count += i >= theirs.size() || !mine[i].chunk.shares_with(theirs[i].chunk);
  return count;
}

void LandmarkStore::save(OutArchive& out) const {
  out.section("landmarks", 1);
  out.value(static_cast<std::uint64_t>(directory_->entries.size()));
  out.value(static_cast<std::uint64_t>(directory_->count));
  out.value(directory_->next_id);
  for (const Entry& entry : directory_->entries) {
    out.value(static_cast<std::int32_t>(entry.used));
    out.value(entry.box.low);
    out.value(entry.box.high);
    if (!out.first_sight(entry.chunk.identity())) continue;  // particles share chunks: once is enough
    for (const Landmark& landmark : entry.chunk->places) {
      out.value(landmark.mean);
      out.value(landmark.P);
      out.value(landmark.P_floor);
      out.value(static_cast<std::uint32_t>(landmark.signature.size()));
      for (const float bin : landmark.signature) out.value(bin);
      out.value(landmark.identity);
      out.value(landmark.log_odds);
      out.value(landmark.sightings);
      out.value(landmark.id);
    }
  }
}

void LandmarkStore::load(InArchive& in) {
  in.section("landmarks", 1);
  Directory directory;
  std::uint64_t entries = 0;
  std::uint64_t count = 0;
  in.value(entries);
  in.value(count);
  in.value(directory.next_id);
  directory.count = count;
  for (std::uint64_t e = 0; e < entries; ++e) {
    Entry entry;
    std::int32_t used = 0;
    in.value(used);
    entry.used = used;
    in.value(entry.box.low);
    in.value(entry.box.high);
    std::uint64_t number = 0;
    if (const auto known = in.shared(number)) {
      entry.chunk = *std::static_pointer_cast<Cow<Chunk>>(known);
    } else {
      for (Landmark& landmark : entry.chunk.write().places) {
        in.value(landmark.mean);
        in.value(landmark.P);
        in.value(landmark.P_floor);
        std::uint32_t bins = 0;
        in.value(bins);
        if (bins > Signature::kMaxBins) throw DataError("a landmark's signature has " + std::to_string(bins) + " bins");
        if (bins > 0) landmark.signature = Signature::uniform(bins);
        for (float& bin : landmark.signature) in.value(bin);
        in.value(landmark.identity);
        in.value(landmark.log_odds);
        in.value(landmark.sightings);
        in.value(landmark.id);
      }
      in.remember(number, std::make_shared<Cow<Chunk>>(entry.chunk));
    }
    directory.entries.push_back(std::move(entry));
  }
  directory_ = Cow<Directory>(std::move(directory));
}

}  // namespace waymark
