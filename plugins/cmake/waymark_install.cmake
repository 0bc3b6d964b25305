# SPDX-License-Identifier: Apache-2.0
# What `find_package(waymark)` finds: the targets waymark::core, waymark::plugin (for plugins) and waymark::host (for programs that
# run robots; it brings waymark::loader), the function waymark_add_plugin(), and with COMPONENTS testing the contract kit, waymark::testing.
include(CMakePackageConfigHelpers)
set(package_dir lib/cmake/waymark)

install(EXPORT waymark NAMESPACE waymark:: FILE waymark-targets.cmake DESTINATION ${package_dir})
if(TARGET waymark_testing)
  set_target_properties(waymark_testing PROPERTIES EXPORT_NAME testing)
  install(TARGETS waymark_testing EXPORT waymark_testing ARCHIVE DESTINATION lib FILE_SET HEADERS DESTINATION include)
  install(EXPORT waymark_testing NAMESPACE waymark:: FILE waymark-testing-targets.cmake DESTINATION ${package_dir})
endif()

configure_package_config_file(
  ${CMAKE_CURRENT_LIST_DIR}/waymark-config.cmake.in ${PROJECT_BINARY_DIR}/waymark-config.cmake INSTALL_DESTINATION ${package_dir})
# Before 1.0 every minor version may change the interfaces.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/waymark-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/waymark-config.cmake ${PROJECT_BINARY_DIR}/waymark-config-version.cmake
              ${CMAKE_CURRENT_LIST_DIR}/waymark_add_plugin.cmake DESTINATION ${package_dir})
