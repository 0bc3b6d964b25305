// SPDX-License-Identifier: Apache-2.0
// The plugin that stands between a YAML and a class in Python. The module waymark._waymark, which a robot in Python has
// loaded, makes the object.
#include <Python.h>

#include <string>

#include "waymark/base/error.hpp"
#include "waymark/plugin/map_module.hpp"
#include "waymark/plugin/sensor.hpp"

namespace {

using waymark::WAYMARK_PYTHON_INTERFACE;
using Make = WAYMARK_PYTHON_INTERFACE* (*)(const waymark::Config&, const waymark::Rig&);

void* create(const waymark::Config& config, const waymark::Rig& rig) {
  const PyGILState_STATE state = PyGILState_Ensure();
  void* make = PyCapsule_Import(WAYMARK_PYTHON_FACTORY, 0);
  if (make == nullptr) PyErr_Clear();
  PyGILState_Release(state);
  if (make == nullptr) throw waymark::PluginError("the program is not Python with `import waymark`");
  return reinterpret_cast<Make>(make)(config, rig);
}

}  // namespace

WAYMARK_PLUGIN_RECORD(::waymark::make_plugin_record(::waymark::plugin_kind<WAYMARK_PYTHON_INTERFACE>(),
                                                    WAYMARK_PYTHON_NAME, "1.0.0"))
extern "C" __attribute__((visibility("default"))) const ::waymark::PluginDescriptor waymark_plugin;
const ::waymark::PluginDescriptor waymark_plugin = {::waymark::kPluginAbi,
                                                    EIGEN_MAX_ALIGN_BYTES,
                                                    ::waymark::kBuildKey,
                                                    ::waymark::plugin_kind<WAYMARK_PYTHON_INTERFACE>(),
                                                    WAYMARK_PYTHON_NAME,
                                                    "1.0.0",
                                                    &create,
                                                    nullptr};
