// SPDX-License-Identifier: Apache-2.0
#include "map_modules/occupancy_grid/tile.hpp"

#include "waymark/memory/shared_archive.hpp"

namespace waymark::occupancy_grid {

namespace {

template <class Values>
Cow<Values> filled_with(typename Values::value_type value) {
  Values values;
  values.fill(value);
  return Cow<Values>(values);
}

template <class Values>
std::size_t bytes_of(const Cow<Values>& handle, std::set<const void*>& seen) {
  return seen.insert(handle.identity()).second ? sizeof(Values) : 0;
}

/// `initial`: what every tile begins with, which is not written.
template <class Values>
void save_values(const Cow<Values>& handle, const Cow<Values>& initial, OutArchive& out) {
  const bool is_initial = handle.shares_with(initial);
  out.value(is_initial);
  if (!is_initial) save_shared(handle.identity(), out, [&] { out.bytes(handle.read().data(), handle.read().size()); });
}

template <class Values>
Cow<Values> load_values(const Cow<Values>& initial, InArchive& in) {
  bool is_initial = false;
  in.value(is_initial);
  if (is_initial) return initial;
  return load_shared<Cow<Values>>(in, [&] {
    Cow<Values> handle;
    Values& values = handle.write();
    in.bytes(values.data(), values.size());
    return handle;
  });
}

}  // namespace

const Cow<Tile::Odds>& Tile::unknown() {
  static const Cow<Odds> handle = filled_with<Odds>(kUnknown);
  return handle;
}

const Cow<Tile::Distances>& Tile::far() {
  static const Cow<Distances> handle = filled_with<Distances>(kFar);
  return handle;
}

std::size_t Tile::bytes(std::set<const void*>& seen) const {
  return sizeof(Tile) + bytes_of(odds_, seen) + bytes_of(distances_, seen);
}

void Tile::save(OutArchive& out) const {
  save_values(odds_, unknown(), out);
  save_values(distances_, far(), out);
}

void Tile::load(InArchive& in) {
  odds_ = load_values(unknown(), in);
  distances_ = load_values(far(), in);
}

}  // namespace waymark::occupancy_grid
