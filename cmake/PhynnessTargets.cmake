# Functions that declare libraries and tests, so that language level, warnings and include paths are set in one place.
include(GNUInstallDirs)

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)

function(phynness_warnings target)
  target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-Wall -Wextra -Wconversion -Wno-sign-conversion>)
  if(PHYNNESS_WARNINGS_AS_ERRORS)
    target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-Werror>)
  endif()
endfunction()

# phynness_quick_to_compile(TARGET): for code that runs for milliseconds, such as commands, reports and tests. Its compilation
# takes about a third less time without the passes of -O2 and -O3. Other libraries that it calls are still optimized.
# Also for libraries whose files take the compiler longer than their calculations last.
function(phynness_quick_to_compile target)
  if(NOT MSVC)
    target_compile_options(${target} PRIVATE $<$<AND:$<COMPILE_LANGUAGE:CXX>,$<CONFIG:Release>>:-O1>)
  endif()
endfunction()

# Without any pass: clang compiles a test with sanitizers in less than half the time, and gcc in the same. What the tests call
# is optimized as before. Not tests that compute much themselves.
option(PHYNNESS_PLAIN_TESTS "Compile the tests themselves without optimization" OFF)

# Of some hundred cases, most take less time than the start and the end of a process with sanitizers.
option(PHYNNESS_WHOLE_TESTS "Run all cases of a test program in one process" OFF)

# phynness_library(NAME sources...): static library phynness_NAME with alias phynness::NAME, C++20, public headers in include/
function(phynness_library name)
  add_library(phynness_${name} STATIC ${ARGN})
  add_library(phynness::${name} ALIAS phynness_${name})
  target_compile_features(phynness_${name} PUBLIC cxx_std_20)
  target_include_directories(phynness_${name} PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>)
  target_include_directories(phynness_${name} PRIVATE src)
  target_compile_definitions(phynness_${name} PRIVATE PHYNNESS_VERSION="${PROJECT_VERSION}")
  phynness_warnings(phynness_${name})
endfunction()

# phynness_test(NAME SOURCES ... LIBRARIES ... [TIMEOUT seconds]): a Google Test program whose cases CTest discovers.
# Those of phynness_sanitized_tests have the label sanitized.
function(phynness_test name)
  phynness_test_program(${name} ${ARGN})
  set(label "")
  if(name IN_LIST phynness_sanitized_tests)
    set(label LABELS sanitized)
    if(NOT PHYNNESS_SANITIZED_TESTS AND NOT name STREQUAL runtime)
      set_target_properties(test_${name} PROPERTIES EXCLUDE_FROM_ALL ON)
      return()
    endif()
  endif()
  phynness_discover_tests(${name} PREFIX ${name}/ ${label} ${ARGN})
endfunction()

function(phynness_test_program name)
  cmake_parse_arguments(arg "" "TIMEOUT" "SOURCES;LIBRARIES" ${ARGN})
  add_executable(test_${name} ${arg_SOURCES})
  target_link_libraries(test_${name} PRIVATE ${arg_LIBRARIES} GTest::gtest_main)
  target_compile_features(test_${name} PRIVATE cxx_std_20)
  phynness_warnings(test_${name})
  phynness_quick_to_compile(test_${name})
  if(PHYNNESS_PLAIN_TESTS AND NOT name MATCHES "^(runtime|training|embedded|meshes|planning|loop|threads)")
    target_compile_options(test_${name} PRIVATE -O0)
  endif()
  target_compile_definitions(test_${name} PRIVATE PHYNNESS_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endfunction()

function(phynness_discover_tests name)
  cmake_parse_arguments(arg "" "TIMEOUT;PREFIX;LABELS" "SOURCES;LIBRARIES;ENVIRONMENT" ${ARGN})
  if(arg_LABELS)
    set(arg_LABELS LABELS ${arg_LABELS})
  endif()
  if(NOT arg_TIMEOUT)
    set(arg_TIMEOUT 300)
  endif()
  set(environment "OMP_NUM_THREADS=1;OPENBLAS_NUM_THREADS=1;${arg_ENVIRONMENT}")
  if(PHYNNESS_WHOLE_TESTS)
    add_test(NAME ${name} COMMAND test_${name})
    set_tests_properties(${name} PROPERTIES TIMEOUT 1500 ${arg_LABELS} ENVIRONMENT "${environment}")
  else()
    gtest_discover_tests(test_${name} TEST_PREFIX ${arg_PREFIX} DISCOVERY_TIMEOUT 60
      PROPERTIES TIMEOUT ${arg_TIMEOUT} ${arg_LABELS} ENVIRONMENT "${environment}")
  endif()
endfunction()
