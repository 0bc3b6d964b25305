# SPDX-License-Identifier: Apache-2.0
# Headers of others that nearly every file includes, compiled once for the builds with sanitizers. With clang only: a file that forgets an
# include is found by the other builds, and g++ gains little. Not installed.
set(WAYMARK_COMPILES_HEADERS OFF)
if(WAYMARK_SANITIZE AND WAYMARK_BUILD_TESTS AND CMAKE_CXX_COMPILER_ID MATCHES Clang)
  set(WAYMARK_COMPILES_HEADERS ON)
endif()

# waymark_compile_headers(target headers...): compiles the headers with the options of `target`, which builds nothing else; the file is
# the target's property WAYMARK_COMPILED_HEADERS.
function(waymark_compile_headers target)
  target_compile_options(${target} PRIVATE "SHELL:-Xclang -fno-pch-timestamp") # else ccache takes no object
  target_precompile_headers(${target} PRIVATE ${ARGN})
  # The compiled headers contain paths, so the compiler cache would know no object in another clone. With CCACHE_PCH_EXTSUM it takes
  # this for them: the hash of what they consist of.
  set(compiled ${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/${target}.dir/cmake_pch.hxx)
  set(folders "$<TARGET_PROPERTY:${target},INCLUDE_DIRECTORIES>")
  add_custom_command(
    OUTPUT ${compiled}.pch.sum
    COMMAND sh -c "\"$@\" | sed 's#${PROJECT_SOURCE_DIR}/##g' | sha256sum > ${compiled}.pch.sum" -- ${CMAKE_CXX_COMPILER} -std=c++20 "-I$<JOIN:${folders},;-I>" -w -x c++ -E -dD -P
            ${compiled}
    DEPENDS ${compiled}.pch
    COMMAND_EXPAND_LISTS VERBATIM)
  add_custom_target(${target}_sum DEPENDS ${compiled}.pch.sum)
  set_target_properties(${target} PROPERTIES WAYMARK_COMPILED_HEADERS ${compiled}.pch)
endfunction()

# waymark_use_headers(target headers): compiles `target` with them. Its options must be the same as those of the headers.
function(waymark_use_headers target headers)
  # Not by target_precompile_headers(REUSE_FROM): its options are absolute paths that the compiler cache takes for other options.
  get_target_property(compiled ${headers} WAYMARK_COMPILED_HEADERS)
  target_compile_options(${target} PRIVATE "SHELL:-include-pch ${compiled}")
  add_dependencies(${target} ${headers}_sum)
endfunction()

# waymark_add_headers(target): for libraries, compiled as `target`.
function(waymark_add_headers target)
  file(CONFIGURE OUTPUT headers.cpp CONTENT "int main() {}\n")
  add_library(${target} OBJECT EXCLUDE_FROM_ALL ${CMAKE_CURRENT_BINARY_DIR}/headers.cpp)
  target_link_libraries(${target} PRIVATE Eigen3::Eigen)
  waymark_compile_headers(
    ${target}
    <Eigen/Cholesky> <Eigen/Core> <Eigen/Eigenvalues> <Eigen/Geometry> <Eigen/LU> <Eigen/QR> <Eigen/SVD>
    <algorithm> <array> <atomic> <chrono> <cmath> <condition_variable> <deque> <filesystem> <fstream> <functional> <limits> <map>
    <memory> <mutex> <numeric> <optional> <random> <ranges> <regex> <set> <span> <sstream> <string> <string_view> <thread> <tuple>
    <unordered_map> <utility> <variant> <vector>)
endfunction()

# waymark_use_headers_in(folders...): all libraries below these folders.
function(waymark_use_headers_in)
  foreach(folder IN LISTS ARGN)
    get_directory_property(below DIRECTORY ${folder} SUBDIRECTORIES)
    waymark_use_headers_in(${below})
    get_directory_property(targets DIRECTORY ${folder} BUILDSYSTEM_TARGETS)
    foreach(target IN LISTS targets)
      get_target_property(type ${target} TYPE)
      if(type MATCHES "^(STATIC|SHARED|MODULE|OBJECT)_LIBRARY$")
        get_target_property(visibility ${target} CXX_VISIBILITY_PRESET)
        if(visibility STREQUAL "hidden")
          waymark_use_headers(${target} waymark_hidden_headers)
        else()
          waymark_use_headers(${target} waymark_headers)
        endif()
      endif()
    endforeach()
  endforeach()
endfunction()
