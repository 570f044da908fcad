# phynness_solver_test(NAME sources...): a test of the solver that may look behind its public headers, in a process
# that owns PETSc and MPI. Linear algebra runs on one thread, so that results repeat.
function(phynness_solver_test name)
  phynness_test(${name}
    SOURCES ${ARGN} ${PROJECT_SOURCE_DIR}/tests/solver_test_main.cpp
    LIBRARIES phynness::precompute phynness_dolfinx)
  target_include_directories(test_${name} PRIVATE
    ${PROJECT_SOURCE_DIR}/tests ${PROJECT_SOURCE_DIR}/precompute_dolfinx/src)
endfunction()
