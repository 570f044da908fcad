# phynness_solver_test(NAME sources...): a test of the solver that may look behind its public headers, in a process
# that owns PETSc and MPI. Linear algebra runs on one thread, so that results repeat.
# phynness_solver_test(NAME EVERY_BLAS sources...): once with each of three sets of OpenBLAS kernels. OpenBLAS picks
# them by processor, and they round differently: what a test claims must not hang on that.
function(phynness_solver_test name)
  cmake_parse_arguments(arg "EVERY_BLAS" "" "" ${ARGN})
  phynness_test(${name}
    SOURCES ${arg_UNPARSED_ARGUMENTS} ${PROJECT_SOURCE_DIR}/tests/solver_test_main.cpp
    LIBRARIES phynness::precompute phynness_dolfinx phynness_declared_laws)
  target_include_directories(test_${name} PRIVATE
    ${PROJECT_SOURCE_DIR}/tests ${PROJECT_SOURCE_DIR}/precompute_dolfinx/src)
  if(arg_EVERY_BLAS)
    foreach(kernels SkylakeX Haswell Prescott)
      gtest_discover_tests(test_${name} TEST_PREFIX "${name}/${kernels}/" DISCOVERY_TIMEOUT 60
        PROPERTIES TIMEOUT 300
        ENVIRONMENT "OMP_NUM_THREADS=1;OPENBLAS_NUM_THREADS=1;OPENBLAS_CORETYPE=${kernels}")
    endforeach()
  endif()
endfunction()
