# SPDX-License-Identifier: Apache-2.0
# How every target of this repository is compiled. Not installed.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(Boost 1.74 REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(fmt REQUIRED)
find_package(Threads REQUIRED)

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)
set(WAYMARK_PLUGIN_OUTPUT_DIR ${CMAKE_BINARY_DIR}/lib/waymark/plugins)
set(CMAKE_INSTALL_RPATH "$ORIGIN/../lib;$ORIGIN/../..")

# What links to a shared library need not be linked again when only the library's inside changed.
set(CMAKE_LINK_DEPENDS_NO_SHARED ON)
find_program(WAYMARK_MOLD mold)
if(WAYMARK_MOLD)
  add_link_options(-fuse-ld=mold)
endif()

add_compile_options(-Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor)
if(WAYMARK_WERROR)
  add_compile_options(-Werror)
endif()
# Paths in assertions count from here: the compiler cache knows the objects of another checkout, too.
add_compile_options(-fmacro-prefix-map=${PROJECT_SOURCE_DIR}/=)
set(WAYMARK_SANITIZED OFF)
set(WAYMARK_IF_BUILT "") # of an installation
if(WAYMARK_SANITIZE)
  set(WAYMARK_SANITIZED ON)
  set(WAYMARK_IF_BUILT OPTIONAL) # tests/extensions/sanitized installs the libraries alone
  add_compile_options(-fsanitize=${WAYMARK_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${WAYMARK_SANITIZE})
  # In the code of other libraries, pointers are not looked at: Eigen's inlined operators make that a third of the compiler's time.
  # AddressSanitizer looks at what they point to. The path is relative, and named after its contents, for the compiler cache.
  if(WAYMARK_SANITIZE MATCHES undefined AND CMAKE_CXX_COMPILER_ID STREQUAL Clang AND CMAKE_GENERATOR STREQUAL Ninja)
    set(ignored "[null|alignment|object-size|pointer-overflow|vptr]\nsrc:/usr/*\n")
    string(MD5 digest "${ignored}")
    file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/sanitizers_ignore_${digest}.txt CONTENT "${ignored}" @ONLY)
    add_compile_options(-fsanitize-ignorelist=sanitizers_ignore_${digest}.txt)
  endif()
  # Instrumented, moves of std::optional look to GCC as if they read what they do not; the other builds keep this warning.
  add_compile_options($<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
endif()

# waymark_use_fmt_inside(target): fmt for an installed static library: whoever links it needs no fmt. As headers, but its formatting is
# compiled once for the library instead of with each source, which takes five times as long.
set(WAYMARK_SHARED_FMT ${CMAKE_CURRENT_LIST_DIR}/shared_fmt)
function(waymark_use_fmt_inside target)
  target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:fmt::fmt-header-only>)
  target_compile_options(${target} PRIVATE "SHELL:-include ${WAYMARK_SHARED_FMT}.hpp")
  target_sources(${target} PRIVATE ${WAYMARK_SHARED_FMT}.cpp)
endfunction()
