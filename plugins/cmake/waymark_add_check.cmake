# SPDX-License-Identifier: Apache-2.0
# waymark_add_check(name files...): a program check_<name> that runs the contract kit on a plugin, as the test check_<name> of ctest.
macro(waymark_add_check name)
  enable_testing() # for the folder of the caller, so this is no function
  add_executable(check_${name} ${ARGN})
  target_link_libraries(check_${name} PRIVATE waymark::plugin waymark::testing)
  add_test(NAME check_${name} COMMAND check_${name})
endmacro()
