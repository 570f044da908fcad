# phynness_solver_test(NAME sources...): a test of the solver that may look behind its public headers, in a process
# that owns PETSc and MPI. Linear algebra runs on one thread, so that results repeat.
# phynness_solver_test(NAME EVERY_BLAS sources...): once with each of three sets of OpenBLAS kernels. OpenBLAS picks
# them by processor, and they round differently: what a test claims must not hang on that.
function(phynness_solver_test name)
  cmake_parse_arguments(arg "EVERY_BLAS" "" "" ${ARGN})
  phynness_test_program(${name}
    SOURCES ${arg_UNPARSED_ARGUMENTS} ${PROJECT_SOURCE_DIR}/tests/solver_test_main.cpp
    LIBRARIES phynness::precompute phynness_dolfinx phynness_declared_laws)
  target_include_directories(test_${name} PRIVATE
    ${PROJECT_SOURCE_DIR}/tests ${PROJECT_SOURCE_DIR}/precompute_dolfinx/src)
  # The headers of dolfinx take most of a test's compilation; the first program compiles them for all.
  get_property(first GLOBAL PROPERTY phynness_first_solver_test)
  if(first)
    target_precompile_headers(test_${name} REUSE_FROM ${first})
  else()
    target_precompile_headers(test_${name} PRIVATE <gtest/gtest.h> ${PROJECT_SOURCE_DIR}/tests/body_states.hpp
      ${PROJECT_SOURCE_DIR}/tests/solver_cases.hpp)
    set_property(GLOBAL PROPERTY phynness_first_solver_test test_${name})
  endif()
  # All cases in one process: starting PETSc and MPI takes as long as most of them. `build/release/tests/FOLDER/test_NAME
  # --gtest_filter=CASE` runs one.
  if(arg_EVERY_BLAS)
    foreach(kernels Haswell SkylakeX Prescott)
      phynness_add_solver_test(${name}/${kernels} test_${name} OPENBLAS_CORETYPE=${kernels})
    endforeach()
  else()
    phynness_add_solver_test(${name} test_${name} "")
  endif()
endfunction()

function(phynness_add_solver_test name program environment)
  add_test(NAME ${name} COMMAND ${program})
  set_tests_properties(${name} PROPERTIES TIMEOUT 900
    ENVIRONMENT "OMP_NUM_THREADS=1;OPENBLAS_NUM_THREADS=1;${environment}")
endfunction()
