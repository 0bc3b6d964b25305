# SPDX-License-Identifier: Apache-2.0
# What `find_package(waymark)` finds: the targets waymark::core, waymark::plugin (for plugins) and waymark::host (for programs that
# run robots; it brings waymark::loader), the function waymark_add_plugin(), and with COMPONENTS testing the contract kit: waymark::testing and waymark_add_check().
include(CMakePackageConfigHelpers)
set(package_dir lib/cmake/waymark)

install(EXPORT waymark NAMESPACE waymark:: FILE waymark-targets.cmake DESTINATION ${package_dir})
# In a file of its own: who packages waymark may leave the kit out.
install(EXPORT waymark_testing NAMESPACE waymark:: FILE waymark-testing-targets.cmake DESTINATION ${package_dir})

set(WAYMARK_READS_FLIGHT_RECORDS OFF)
if(TARGET waymark_mcap)
  set(WAYMARK_READS_FLIGHT_RECORDS ON)
endif()
configure_package_config_file(
  ${CMAKE_CURRENT_LIST_DIR}/waymark-config.cmake.in ${PROJECT_BINARY_DIR}/waymark-config.cmake INSTALL_DESTINATION ${package_dir})
# Before 1.0 every minor version may change the interfaces.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/waymark-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/waymark-config.cmake ${PROJECT_BINARY_DIR}/waymark-config-version.cmake
              ${CMAKE_CURRENT_LIST_DIR}/waymark_add_plugin.cmake ${CMAKE_CURRENT_LIST_DIR}/waymark_add_check.cmake
        DESTINATION ${package_dir})

# Licence, pages, shipped configurations, and the example projects for plugins and hosts.
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CONTRIBUTING.md
        DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs DESTINATION ${CMAKE_INSTALL_DOCDIR} PATTERN update_keys EXCLUDE)
# The pages of the plugins, which those in docs link to.
file(GLOB_RECURSE pages CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/plugins/*/README.md
     ${PROJECT_SOURCE_DIR}/sensors/*/README.md ${PROJECT_SOURCE_DIR}/map_modules/*/README.md)
list(FILTER pages EXCLUDE REGEX node_modules)
foreach(page IN LISTS pages)
  cmake_path(GET page PARENT_PATH folder)
  install(FILES ${PROJECT_SOURCE_DIR}/${page} DESTINATION ${CMAKE_INSTALL_DOCDIR}/${folder})
endforeach()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/config DESTINATION ${CMAKE_INSTALL_DATADIR}/waymark)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/tests/consumer/project/ DESTINATION ${CMAKE_INSTALL_DATADIR}/waymark/examples/plugins)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/tests/consumer/host/ DESTINATION ${CMAKE_INSTALL_DATADIR}/waymark/examples/host)
