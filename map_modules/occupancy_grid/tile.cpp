// SPDX-License-Identifier: Apache-2.0
#include "map_modules/occupancy_grid/tile.hpp"

#include "waymark/memory/shared_archive.hpp"

namespace waymark::occupancy_grid {

template <class Value, Value kInitial>
const Cow<typename StripValues<Value, kInitial>::Strip>& StripValues<Value, kInitial>::initial() {
  static const Cow<Strip> handle = [] {
    Strip values;
    values.fill(kInitial);
    return Cow<Strip>(values);
  }();
  return handle;
}

template <class Value, Value kInitial>
std::size_t StripValues<Value, kInitial>::bytes(std::set<const void*>& seen) const {
  std::size_t bytes = sizeof(*this);
  for (const Cow<Strip>& strip : strips_) {
    if (seen.insert(strip.identity()).second) bytes += sizeof(Strip);
  }
  return bytes;
}

template <class Value, Value kInitial>
void StripValues<Value, kInitial>::save(OutArchive& out) const {
  for (const Cow<Strip>& strip : strips_) {
    const bool is_initial = strip.shares_with(initial());  // not written
    out.value(is_initial);
    if (!is_initial) save_shared(strip.identity(), out, [&] { out.bytes(strip.read().data(), sizeof(Strip)); });
  }
}

template <class Value, Value kInitial>
void StripValues<Value, kInitial>::load(InArchive& in) {
  for (Cow<Strip>& strip : strips_) {
    bool is_initial = false;
    in.value(is_initial);
    if (is_initial) {
      strip = initial();
      continue;
    }
    strip = load_shared<Cow<Strip>>(in, [&] {
      Cow<Strip> handle;
      in.bytes(handle.write().data(), sizeof(Strip));
      return handle;
    });
  }
}

template class StripValues<std::int8_t, Tile::kUnknown>;
template class StripValues<std::uint8_t, Tile::kFar>;

}  // namespace waymark::occupancy_grid
