# SPDX-License-Identifier: Apache-2.0
# waymark_add_plugin(name files... [PARTS files...]): a shared library `waymark_<name>.so` that exports one symbol, the plugin's
# descriptor. The files share one `WAYMARK_PLUGIN(...)` line between them. Installs to lib/waymark/plugins.
# Files after PARTS are compiled once, as the object library waymark_<name>_parts, for the plugin and for tests that reach
# behind the plugin's interface. What they need is linked to the parts (PUBLIC); the plugin has it from them.
# Without a build type this is a Release build: without optimisation Eigen is several times as slow.
function(waymark_add_plugin name)
  get_property(has_configurations GLOBAL PROPERTY GENERATOR_IS_MULTI_CONFIG)
  if(NOT CMAKE_BUILD_TYPE AND NOT has_configurations)
    message(STATUS "waymark: no build type is given, so this is a Release build (-DCMAKE_BUILD_TYPE=... for another)")
    set(CMAKE_BUILD_TYPE Release CACHE STRING "Debug, Release, RelWithDebInfo or MinSizeRel" FORCE)
  endif()
  cmake_parse_arguments(PARSE_ARGV 1 plugin "" "" PARTS)
  set(target waymark_plugin_${name})
  set(parts waymark_${name}_parts)
  add_library(${target} MODULE ${plugin_UNPARSED_ARGUMENTS})
  target_link_libraries(${target} PRIVATE waymark::plugin)
  set(hidden CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  set_target_properties(${target} PROPERTIES PREFIX "" OUTPUT_NAME waymark_${name} ${hidden})
  if(plugin_PARTS)
    add_library(${parts} OBJECT ${plugin_PARTS})
    target_link_libraries(${parts} PUBLIC waymark::plugin)
    target_include_directories(${parts} PUBLIC ${CMAKE_CURRENT_SOURCE_DIR})
    set_target_properties(${parts} PROPERTIES POSITION_INDEPENDENT_CODE ON ${hidden})
    target_link_libraries(${target} PRIVATE ${parts})
  endif()
  # With sanitizers the run-time library is only linked into the program, so its symbols are undefined here.
  if(NOT WAYMARK_SANITIZED)
    target_link_options(${target} PRIVATE LINKER:--no-undefined)
  endif()
  if(WAYMARK_PLUGIN_OUTPUT_DIR)
    set_target_properties(${target} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${WAYMARK_PLUGIN_OUTPUT_DIR})
  endif()
  set_property(GLOBAL APPEND PROPERTY WAYMARK_PLUGINS ${target})
  install(TARGETS ${target} LIBRARY DESTINATION lib/waymark/plugins ${WAYMARK_IF_BUILT})
endfunction()
