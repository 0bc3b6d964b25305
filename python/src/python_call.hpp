// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <string>

namespace waymark::python {

/// A Python object that may be copied and dropped by any thread, with or without the GIL.
using Held = std::shared_ptr<pybind11::object>;

/// Takes the object; the GIL is held.
Held hold(pybind11::object object);

/// Throws what a Python exception means to the host: ConfigError and DataError are themselves, KeyboardInterrupt and
/// all others std::runtime_error, in one line with the place in the Python file. The GIL is held.
[[noreturn]] void throw_as_host_error(pybind11::error_already_set& error);

/// Calls `function` with the GIL, from any thread.
template <class Function>
decltype(auto) with_gil(const Function& function) {
  const pybind11::gil_scoped_acquire held;
  try {
    return function();
  } catch (pybind11::error_already_set& error) {
    throw_as_host_error(error);
  }
}

}  // namespace waymark::python
