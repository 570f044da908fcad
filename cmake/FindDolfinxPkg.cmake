# Finds dolfinx (precompute_dolfinx/dolfinx_api.hpp lists the versions) with PETSc, MPI, basix and ufcx.h by pkg-config, and
# ffcx by Python. The pkg-config file of dolfinx has a macro with quotes that break shells, and the option -fpermissive, so
# that only include paths, libraries and a few definitions are taken from it. Defines the target phynness_dolfinx and the
# function phynness_compile_forms().
find_package(PkgConfig REQUIRED)
find_package(MPI REQUIRED COMPONENTS C CXX)

foreach(module IN ITEMS dolfinx dolfinx_real)
  pkg_check_modules(DOLFINX QUIET ${module})
  if(DOLFINX_FOUND)
    break()
  endif()
endforeach()
if(NOT DOLFINX_FOUND)
  message(FATAL_ERROR "dolfinx was not found by pkg-config (dolfinx.pc or dolfinx_real.pc). "
    "Install it (Debian: libdolfinx-dev, or run tools/install-deps), or configure with -DPHYNNESS_WITH_DOLFINX=OFF.")
endif()
pkg_check_modules(PETSC REQUIRED PETSc)

# The Python of the system, for which the package manager has installed ffcx.
find_program(PHYNNESS_PYTHON NAMES python3 PATHS /usr/bin NO_DEFAULT_PATH)
if(NOT PHYNNESS_PYTHON)
  find_program(PHYNNESS_PYTHON NAMES python3 REQUIRED)
endif()
execute_process(
  COMMAND ${PHYNNESS_PYTHON} -c "import ffcx.codegeneration as c; print(c.get_include_path())"
  OUTPUT_VARIABLE UFCX_INCLUDE_DIR OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_VARIABLE ffcx_error RESULT_VARIABLE ffcx_result)
if(NOT ffcx_result EQUAL 0)
  message(FATAL_ERROR "ffcx, the form compiler, was not found by ${PHYNNESS_PYTHON}: ${ffcx_error}\n"
    "Install it (Debian: python3-ffcx).")
endif()

string(REGEX MATCH "^([0-9]+)\\.([0-9]+)" _ "${DOLFINX_VERSION}")
math(EXPR DOLFINX_VERSION_NUMBER "${CMAKE_MATCH_1} * 100 + ${CMAKE_MATCH_2}")

add_library(phynness_dolfinx INTERFACE)
# Only the definitions that the headers of dolfinx need: the configuration of mdspan, and two texts, whose quotes are lost.
set(dolfinx_definitions ${DOLFINX_CFLAGS_OTHER})
list(FILTER dolfinx_definitions INCLUDE REGEX "^-D(MDSPAN_|UFCX_SIGNATURE|DOLFINX_GIT_COMMIT_HASH)")
list(TRANSFORM dolfinx_definitions REPLACE "^-D" "")
list(TRANSFORM dolfinx_definitions REPLACE "[\"\\\\]" "")
list(TRANSFORM dolfinx_definitions REPLACE "^(UFCX_SIGNATURE|DOLFINX_GIT_COMMIT_HASH)=(.*)$" "\\1=\"\\2\"")
target_compile_definitions(phynness_dolfinx INTERFACE ${dolfinx_definitions})
# Since 0.9 dolfinx logs by spdlog. The build options of spdlog determine whether both use the same log.
if(DOLFINX_VERSION_NUMBER GREATER_EQUAL 9)
  pkg_check_modules(SPDLOG REQUIRED IMPORTED_TARGET spdlog)
  target_link_libraries(phynness_dolfinx INTERFACE PkgConfig::SPDLOG)
endif()
target_include_directories(phynness_dolfinx SYSTEM INTERFACE ${UFCX_INCLUDE_DIR} ${DOLFINX_INCLUDE_DIRS} ${PETSC_INCLUDE_DIRS})
target_link_libraries(phynness_dolfinx INTERFACE ${DOLFINX_LINK_LIBRARIES} ${PETSC_LINK_LIBRARIES} MPI::MPI_CXX)
find_library(PHYNNESS_BASIX_LIBRARY basix REQUIRED)
# For our own LDL^T; PETSc needs BLAS too.
find_library(PHYNNESS_BLAS_LIBRARY blas REQUIRED)
find_library(PHYNNESS_METIS_LIBRARY metis REQUIRED)
find_path(PHYNNESS_METIS_INCLUDE_DIR metis.h REQUIRED)
target_include_directories(phynness_dolfinx SYSTEM INTERFACE ${PHYNNESS_METIS_INCLUDE_DIR})
target_link_libraries(phynness_dolfinx INTERFACE ${PHYNNESS_BASIX_LIBRARY} ${PHYNNESS_METIS_LIBRARY} ${PHYNNESS_BLAS_LIBRARY})
target_compile_definitions(phynness_dolfinx INTERFACE
  DOLFINX_VERSION="${DOLFINX_VERSION}" PHYNNESS_DOLFINX=${DOLFINX_VERSION_NUMBER} OMPI_SKIP_MPICXX MPICH_SKIP_MPICXX)
message(STATUS "dolfinx ${DOLFINX_VERSION}, PETSc ${PETSC_VERSION}, ffcx include ${UFCX_INCLUDE_DIR}")

# phynness_compile_forms(TARGET file.py ...): compiles each form file to C by ffcx and adds it to TARGET. The names of headers
# are those of the form files.
function(phynness_compile_forms target)
  set(generated "${CMAKE_CURRENT_BINARY_DIR}/forms")
  file(MAKE_DIRECTORY "${generated}")
  set(forms "${PROJECT_SOURCE_DIR}/precompute_dolfinx/forms")
  set(tables "${PROJECT_SOURCE_DIR}/laws/tables")
  foreach(form IN LISTS ARGN)
    get_filename_component(name "${form}" NAME_WE)
    set(modules law_forms mechanics elements)
    if(name MATCHES "^shell_")
      set(modules law_forms shell shell_elements)
    endif()
    list(TRANSFORM modules REPLACE "(.+)" "${forms}/\\1.py")
    list(APPEND modules "${tables}/law.py" "${tables}/hooke.py" "${tables}/element_table.py")
    # The law of a form file that tables.py made.
    string(REGEX REPLACE "^shell_" "" law "${name}")
    set(law "${PROJECT_SOURCE_DIR}/laws/${law}.py")
    if(EXISTS "${law}")
      list(APPEND modules "${law}")
    endif()
    add_custom_command(
      OUTPUT "${generated}/${name}.c" "${generated}/${name}.h"
      COMMAND ${CMAKE_COMMAND} -E env "PYTHONPATH=${forms}:${tables}" PYTHONDONTWRITEBYTECODE=1
              ${PHYNNESS_PYTHON} -m ffcx "${form}"
      WORKING_DIRECTORY "${generated}"  # the option for this folder has another name since ffcx 0.11
      DEPENDS "${form}" ${modules}
      COMMENT "ffcx ${name}" VERBATIM)
    target_sources(${target} PRIVATE "${generated}/${name}.c")
    # Without -ffast-math, because NaN indicates J <= 0.
    set_source_files_properties("${generated}/${name}.c" PROPERTIES COMPILE_OPTIONS "-O2;-w" SKIP_LINTING ON)
  endforeach()
  target_include_directories(${target} PRIVATE "${generated}")
endfunction()
