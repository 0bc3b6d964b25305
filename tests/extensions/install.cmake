# SPDX-License-Identifier: Apache-2.0
# Installs the build in BUILD_DIR below WORK_DIR.
file(REMOVE_RECURSE ${WORK_DIR})
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/install OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
