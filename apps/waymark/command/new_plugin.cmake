# SPDX-License-Identifier: Apache-2.0
cmake_minimum_required(VERSION 3.25) # a script has no policies but these
# Writes the templates of `waymark new` as C++: the files of `folder`, with the version of waymark in the place of @version@.
function(entry kind file name)
  file(READ ${file} text)
  string(REPLACE "@version@" "${version}" text "${text}")
  if(text MATCHES "\\)waymark\"")
    message(FATAL_ERROR "${file} contains what ends a literal")
  endif()
  set(entries "${entries}    {\"${kind}\", \"${name}\", R\"waymark(${text})waymark\"},\n" PARENT_SCOPE)
endfunction()

set(entries "")
foreach(kind IN ITEMS sensor map-module source sink)
  entry(${kind} ${folder}/CMakeLists.txt.in CMakeLists.txt)
  entry(${kind} ${folder}/${kind}/plugin.cpp.in @name@.cpp)
  entry(${kind} ${folder}/${kind}/check.cpp.in check_@name@.cpp)
  entry(${kind} ${folder}/${kind}/robot.yaml.in robot.yaml)
endforeach()
file(
  WRITE ${out}
  "// Made by new_plugin.cmake.
#include \"apps/waymark/command/new_plugin.hpp\"

namespace waymark::command {
namespace {

constexpr TemplateFile kFiles[] = {
${entries}};

}  // namespace

std::span<const TemplateFile> plugin_templates() { return kFiles; }

}  // namespace waymark::command
")
