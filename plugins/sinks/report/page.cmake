# SPDX-License-Identifier: Apache-2.0
# Writes the page around a report's data as C++: page/index.html with style sheets and scripts in the places of {{license}}, {{style}},
# {{uplot}} and {{script}}, cut in two at {{data}}. Each file is a literal of its own: compilers accept 64 kB.
function(literal text)
  if(text MATCHES "\\)waymark\"")
    message(FATAL_ERROR "a file of the page contains what ends a literal")
  endif()
  set(literals "${literals}    R\"waymark(${text})waymark\",\n" PARENT_SCOPE)
endfunction()

function(literal_of_file file)
  file(READ ${file} text)
  literal("${text}")
  set(literals "${literals}" PARENT_SCOPE)
endfunction()

# Appends a part of the page; its marks {{name}} stand for files.
function(part text)
  while(text MATCHES "{{([a-z]+)}}")
    set(name ${CMAKE_MATCH_1})
    string(FIND "${text}" "{{${name}}}" place)
    string(SUBSTRING "${text}" 0 ${place} before)
    string(LENGTH "{{${name}}}" length)
    math(EXPR place "${place} + ${length}")
    string(SUBSTRING "${text}" ${place} -1 text)
    literal("${before}")
    foreach(file IN LISTS files_${name})
      literal_of_file(${file})
    endforeach()
  endwhile()
  literal("${text}")
  set(literals "${literals}" PARENT_SCOPE)
endfunction()

set(files_style ${uplot}/uPlot.min.css ${folder}/style.css)
set(files_uplot ${uplot}/uPlot.iife.min.js)
set(files_license ${uplot}/../LICENSE)
set(files_script ${folder}/format.js ${folder}/map_view.js ${folder}/map_layers.js ${folder}/map.js
    ${folder}/charts.js ${folder}/panels.js ${folder}/main.js)

file(READ ${folder}/index.html html)
string(FIND "${html}" "{{data}}" place)
string(SUBSTRING "${html}" 0 ${place} before)
math(EXPR place "${place} + 8")
string(SUBSTRING "${html}" ${place} -1 after)

part("${before}")
set(literals_before "${literals}")
set(literals "")
part("${after}")
file(
  WRITE ${out}
  "// Made by page.cmake.
#include \"page.hpp\"

namespace waymark::report {
namespace {

constexpr std::string_view kBefore[] = {
${literals_before}};

constexpr std::string_view kAfter[] = {
${literals}};

}  // namespace

Page page() { return {kBefore, kAfter}; }

}  // namespace waymark::report
")
