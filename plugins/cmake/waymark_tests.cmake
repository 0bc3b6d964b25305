# SPDX-License-Identifier: Apache-2.0
# How the tests of this repository are put together. Not installed.

# waymark_missing_plugins(file missing): a test names the plugins that it loads in a line "// needs plugins: dgps, odometry" of its own;
# this gives those that are not there.
function(waymark_missing_plugins file missing)
  waymark_needed_plugins(${file} plugins)
  set(absent "")
  foreach(plugin IN LISTS plugins)
    if(NOT TARGET waymark_plugin_${plugin})
      list(APPEND absent ${plugin})
    endif()
  endforeach()
  set(${missing} "${absent}" PARENT_SCOPE)
endfunction()

function(waymark_needed_plugins file plugins)
  file(STRINGS ${file} lines REGEX "^// needs plugins: ")
  string(REGEX REPLACE "// needs plugins: " "" lines "${lines}")
  string(REGEX REPLACE "[, ;]+" ";" lines "${lines}")
  list(REMOVE_DUPLICATES lines)
  set(${plugins} "${lines}" PARENT_SCOPE)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
endfunction()

# waymark_add_test_program(name KIND unit|contract|... [PREFIX text] [TIMEOUT s] [ABSOLUTE] FILES files...): one program of several
# test files. Paths in its definitions are relative to the build folder, see main.cpp; with ABSOLUTE they are not.
# Its tests are labelled KIND; under the thread sanitizer those of programs whose name ends in _threads are labelled threads.
# Files whose plugins are not all there are left out, with a message; a program without files is not made.
function(waymark_add_test_program name)
  cmake_parse_arguments(PARSE_ARGV 1 test "ABSOLUTE" "KIND;PREFIX;TIMEOUT" "FILES")
  if(NOT test_TIMEOUT)
    set(test_TIMEOUT 300)
  endif()
  set(files "")
  set(plugins "")
  foreach(file IN LISTS test_FILES)
    cmake_path(ABSOLUTE_PATH file)
    waymark_missing_plugins(${file} missing)
    if(missing)
      cmake_path(RELATIVE_PATH file BASE_DIRECTORY ${PROJECT_SOURCE_DIR})
      list(JOIN missing ", " missing)
      message(STATUS "${file} is left out: it needs ${missing}")
      continue()
    endif()
    list(APPEND files ${file})
    waymark_needed_plugins(${file} needed)
    list(APPEND plugins ${needed})
  endforeach()
  if(NOT files)
    return()
  endif()
  add_executable(${name} ${files})
  set_target_properties(${name} PROPERTIES UNITY_BUILD OFF) # files share names for their own helpers
  if(WAYMARK_SANITIZE OR test_KIND STREQUAL "system")
    target_compile_options(${name} PRIVATE -O0) # compiles in about 0.6 of the time; what is tested keeps the optimization of the preset
  endif()
  target_link_libraries(${name} PRIVATE waymark_test_main waymark::loader fmt::fmt)
  if(TARGET waymark_test_headers)
    # Not by target_precompile_headers(REUSE_FROM): its options are absolute paths that the compiler cache takes for other options.
    target_compile_options(${name} PRIVATE "SHELL:-include-pch ${WAYMARK_TEST_HEADERS}")
    add_dependencies(${name} waymark_test_headers_sum)
  endif()
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/tests ${PROJECT_SOURCE_DIR}/core/src)
  set(plugin_dir ${WAYMARK_PLUGIN_OUTPUT_DIR})
  set(source_dir ${PROJECT_SOURCE_DIR})
  if(NOT test_ABSOLUTE)
    cmake_path(RELATIVE_PATH plugin_dir BASE_DIRECTORY ${PROJECT_BINARY_DIR})
    cmake_path(RELATIVE_PATH source_dir BASE_DIRECTORY ${PROJECT_BINARY_DIR})
  endif()
  target_compile_definitions(${name} PRIVATE WAYMARK_PLUGIN_DIR="${plugin_dir}" WAYMARK_SOURCE_DIR="${source_dir}")
  if(plugins)
    list(REMOVE_DUPLICATES plugins)
    list(TRANSFORM plugins PREPEND waymark_plugin_)
    add_dependencies(${name} ${plugins})
  endif()
  # One label each: gtest_discover_tests cannot pass a list of them.
  set(label ${test_KIND})
  if(name MATCHES "_threads$")
    add_dependencies(threads_tests ${name})
    if(WAYMARK_SANITIZE STREQUAL "thread")
      set(label threads)
    endif()
  endif()
  add_dependencies(${test_KIND}_tests ${name})
  gtest_discover_tests(
    ${name} TEST_PREFIX "${test_PREFIX}" WORKING_DIRECTORY ${PROJECT_BINARY_DIR} DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60
    PROPERTIES LABELS ${label} TIMEOUT ${test_TIMEOUT})
endfunction()
