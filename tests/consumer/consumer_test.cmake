# SPDX-License-Identifier: Apache-2.0
# Installs the build, builds the project in PROJECT_DIR against it, runs its own tests with the contract kit, loads a plugin with
# LOADER, runs the robot made of the others with the installed command, does the same with the programs in HOST_DIR, and checks that the documentation quotes the files as they are.
function(step what)
  message(STATUS "${what}")
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${what}: failed (${result}): ${ARGN}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK_DIR})
step("install" ${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/install)
foreach(file IN ITEMS doc/waymark/LICENSE doc/waymark/docs/write_a_sensor.md doc/waymark/plugins/sources/csv/README.md doc/waymark/sensors/dgps/README.md waymark/config/quickstart.yaml
                      waymark/examples/plugins/beacon_range.cpp waymark/examples/host/run_robot.cpp man/man1/waymark.1)
  if(NOT EXISTS ${WORK_DIR}/install/share/${file})
    message(FATAL_ERROR "share/${file} is not installed")
  endif()
endforeach()
step("check an installed configuration" ${WORK_DIR}/install/bin/waymark check ${WORK_DIR}/install/share/waymark/config/quickstart.yaml)
step(
  "configure"
  ${CMAKE_COMMAND}
  -S
  ${PROJECT_DIR}
  -B
  ${WORK_DIR}/build
  -G
  ${GENERATOR}
  -DCMAKE_CXX_COMPILER=${CXX}
  -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}
  -DCMAKE_BUILD_TYPE=RelWithDebInfo
  -DCMAKE_PREFIX_PATH=${WORK_DIR}/install)
step("build" ${CMAKE_COMMAND} --build ${WORK_DIR}/build)
step("contract kit" ${CMAKE_CTEST_COMMAND} --test-dir ${WORK_DIR}/build --output-on-failure)
step("install the plugins" ${CMAKE_COMMAND} --install ${WORK_DIR}/build --prefix ${WORK_DIR}/install)
step("load" ${LOADER} ${WORK_DIR}/install/lib/waymark/plugins)
step("run" ${WORK_DIR}/install/bin/waymark run ${PROJECT_DIR}/robot.yaml --out ${WORK_DIR}/out --quiet)
foreach(file IN ITEMS distance.csv landmarks.csv)
  file(STRINGS ${WORK_DIR}/out/${file} lines)
  list(LENGTH lines count)
  if(count LESS 2)
    message(FATAL_ERROR "${file}: no rows")
  endif()
endforeach()

# Programs of a user's own, linked to waymark::host.
step(
  "configure the hosts"
  ${CMAKE_COMMAND}
  -S
  ${HOST_DIR}
  -B
  ${WORK_DIR}/host
  -G
  ${GENERATOR}
  -DCMAKE_CXX_COMPILER=${CXX}
  -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}
  -DCMAKE_BUILD_TYPE=RelWithDebInfo
  -DCMAKE_PREFIX_PATH=${WORK_DIR}/install)
step("build the hosts" ${CMAKE_COMMAND} --build ${WORK_DIR}/host)
set(ENV{WAYMARK_PLUGIN_PATH} ${WORK_DIR}/install/lib/waymark/plugins)
step("run a robot" ${WORK_DIR}/host/run_robot ${PROJECT_DIR}/robot.yaml ${WORK_DIR}/host_out)
foreach(file IN ITEMS distance.csv landmarks.csv)
  step("${file} as the command writes it" ${CMAKE_COMMAND} -E compare_files ${WORK_DIR}/out/${file} ${WORK_DIR}/host_out/${file})
endforeach()
execute_process(COMMAND ${WORK_DIR}/host/live_robot OUTPUT_VARIABLE printed RESULT_VARIABLE result)
# 1 m/s from the first measurement, at 0.1 s, to 10.05 s.
if(NOT result EQUAL 0 OR NOT printed MATCHES "now at x (9\\.9|10\\.0)")
  message(FATAL_ERROR "live_robot: failed (${result}): ${printed}")
endif()

# quoted(file page): the page shows the file as it is, and the file stays short enough to be an example.
function(quoted file page)
  file(READ ${PROJECT_DIR}/${file} source)
  file(READ ${DOCS_DIR}/${page} text)
  string(FIND "${text}" "${source}" place)
  if(place EQUAL -1)
    message(FATAL_ERROR "docs/${page} does not quote tests/consumer/project/${file} as it is")
  endif()
  string(REGEX MATCHALL "\n" newlines "${source}")
  list(LENGTH newlines count)
  if(count GREATER 59)
    message(FATAL_ERROR "${file}: ${count} lines; an example stays under 60")
  endif()
endfunction()
quoted(CMakeLists.txt write_a_sensor.md)
quoted(beacon_range.hpp write_a_sensor.md)
quoted(beacon_range.cpp write_a_sensor.md)
quoted(check_beacon_range.cpp write_a_sensor.md)
quoted(dock.hpp write_a_map_module.md)
quoted(dock_map.hpp write_a_map_module.md)
quoted(dock_map.cpp write_a_map_module.md)
quoted(check_dock_map.cpp write_a_map_module.md)
quoted(circle.cpp write_a_source_or_sink.md)
quoted(check_circle.cpp write_a_source_or_sink.md)
quoted(distance.cpp write_a_source_or_sink.md)
quoted(check_distance.cpp write_a_source_or_sink.md)
quoted(robot.yaml write_a_source_or_sink.md)
quoted(../host/CMakeLists.txt write_a_host.md)
quoted(../host/run_robot.cpp write_a_host.md)
quoted(../host/live_robot.cpp write_a_host.md)
