# SPDX-License-Identifier: Apache-2.0
# waymark_add_plugin(name files...): a shared library `waymark_<name>.so` that exports one symbol, the plugin's descriptor.
# The files share one `WAYMARK_PLUGIN(...)` line between them. Installs to lib/waymark/plugins.
function(waymark_add_plugin name)
  set(target waymark_plugin_${name})
  add_library(${target} MODULE ${ARGN})
  target_link_libraries(${target} PRIVATE waymark::plugin)
  set_property(GLOBAL APPEND PROPERTY WAYMARK_PLUGINS ${target})
  set_target_properties(
    ${target}
    PROPERTIES PREFIX "" OUTPUT_NAME waymark_${name} CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  # With sanitizers the run-time library is only linked into the program, so its symbols are undefined here.
  if(NOT WAYMARK_SANITIZED)
    target_link_options(${target} PRIVATE LINKER:--no-undefined)
  endif()
  if(WAYMARK_PLUGIN_OUTPUT_DIR)
    set_target_properties(${target} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${WAYMARK_PLUGIN_OUTPUT_DIR})
  endif()
  install(TARGETS ${target} LIBRARY DESTINATION lib/waymark/plugins)
endfunction()
