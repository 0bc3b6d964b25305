// SPDX-License-Identifier: Apache-2.0
#include "python_call.hpp"

#include <stdexcept>
#include <string_view>
#include <utility>

#include "waymark/base/error.hpp"

namespace py = pybind11;

namespace waymark::python {

Held hold(py::object object) {
  return {new py::object(std::move(object)), [](py::object* held) {
            if (Py_IsInitialized() == 0) return;  // the interpreter has freed it
            const py::gil_scoped_acquire acquired;
            delete held;
          }};
}

void throw_as_host_error(py::error_already_set& error) {
  const py::module_ native = py::module_::import("waymark._waymark");
  std::string text = py::cast<std::string>(py::str(error.value()));
  if (error.matches(native.attr("ConfigError"))) throw ConfigError(text);
  if (error.matches(native.attr("DataError"))) throw DataError(text);
  // For the loop of the run, which ends it: here it came in the middle of a step.
  if (error.matches(PyExc_KeyboardInterrupt)) PyErr_SetInterrupt();
  text = py::cast<std::string>(error.type().attr("__name__")) + ": " + text;
  // Where it happened: the last frame.
  py::object trace = error.trace();
  while (trace && !trace.is_none() && !trace.attr("tb_next").is_none()) trace = trace.attr("tb_next");
  if (trace && !trace.is_none()) {
    text += " (" + py::cast<std::string>(py::str(trace.attr("tb_frame").attr("f_code").attr("co_filename"))) + ":" +
            py::cast<std::string>(py::str(trace.attr("tb_lineno"))) + ")";
  }
  for (char& c : text) {
    if (c == '\n') c = ' ';
  }
  throw std::runtime_error(text);
}

}  // namespace waymark::python
