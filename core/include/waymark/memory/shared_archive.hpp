// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "waymark/io/archive.hpp"

namespace waymark {

/// Writes a shared object: the first time with `save()`, then only its number. `identity` identifies the object.
template <class Save>
void save_shared(const void* identity, OutArchive& out, const Save& save) {
  if (out.first_sight(identity)) save();
}

/// Reads a shared object that `save_shared` wrote: the first time with `load()`, then as copies of that result. A `T`
/// is a handle, whose copies share the object. Throws DataError if the object that is read is a part of itself.
template <class T, class Load>
T load_shared(InArchive& in, const Load& load) {
  std::uint64_t number = 0;
  if (const auto known = in.shared<T>(number)) return *known;
  T object = load();
  in.remember(number, std::make_shared<T>(object));
  return object;
}

}  // namespace waymark
