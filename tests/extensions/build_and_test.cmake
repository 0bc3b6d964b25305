# SPDX-License-Identifier: Apache-2.0
# Builds the project in PROJECT_DIR against the package that is installed below WORK_DIR, and runs its tests.
set(build ${WORK_DIR}/${NAME})
execute_process(
  COMMAND
    ${CMAKE_COMMAND} -S ${PROJECT_DIR} -B ${build} -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${CXX} -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}
    -DCMAKE_EXPORT_COMPILE_COMMANDS=ON # for tests/tidy
    "-DCMAKE_CXX_FLAGS=-Wall -Wextra -Wshadow -Werror" -DCMAKE_PREFIX_PATH=${WORK_DIR}/install COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} --build ${build} COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_CTEST_COMMAND} --test-dir ${build} --output-on-failure COMMAND_ERROR_IS_FATAL ANY)
