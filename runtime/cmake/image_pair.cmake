# Writes phynness_image.h and phynness_image.cpp into OUT: the evaluation of images as two files that need no others. They
# consist of the files of SOURCES in their order, without the includes of each other; of phynness.h only the statuses,
# phn_provenance and what relaxes are taken. phynness_relax.cpp has phn_relax. Usage: cmake -DRUNTIME=... -DOUT=... -DVERSION=... "-DSOURCES=a;b" -P image_pair.cmake
set(made "/* Written by the build of phynness ${VERSION}; do not edit. MIT licence. */\n")

# Text of a file without what only separate files need.
function(read_part file result)
  file(READ ${RUNTIME}/${file} text)
  string(REGEX REPLACE "#pragma once\n|#include (\"|<phynness/)[^\n]*\n" "" text "${text}")
  set(${result} "${text}" PARENT_SCOPE)
endfunction()

read_part(include/phynness/phynness_api.h api)
file(READ ${RUNTIME}/include/phynness/phynness.h core)
string(REGEX MATCH "enum {[^}]*PHN_OK[^}]*};\n" statuses "${core}")
string(REGEX MATCH "typedef struct phn_provenance {[^}]*} phn_provenance;\n" provenance "${core}")
string(REGEX MATCH "enum { PHN_MOST_[^}]*};\n" most "${core}")
string(REGEX MATCH "typedef struct phn_relaxation {[^}]*} phn_relaxation;\n" relaxation "${core}")
string(REGEX MATCH "typedef struct phn_relaxing {[^}]*} phn_relaxing;\n" relaxing "${core}")
string(REGEX MATCH "PHN_API int phn_relax\\([^)]*\\)" relax "${core}")
read_part(include/phynness/phynness_image.h image)
string(REPLACE "#define PHYNNESS_IMAGE_H\n"
  "#define PHYNNESS_IMAGE_H\n\n${api}\n${statuses}\n${provenance}\n${most}\n${relaxation}\n${relaxing}" image "${image}")
string(REPLACE "typedef struct phn_image phn_image;\n" "typedef struct phn_image phn_image;\n${relax};\n" image "${image}")
file(WRITE ${OUT}/phynness_image.h "${made}${image}")

file(WRITE ${OUT}/phynness_image.cpp "${made}#include \"phynness_image.h\"\n")
foreach(file IN LISTS SOURCES)
  read_part(${file} text)
  file(APPEND ${OUT}/phynness_image.cpp "\n${text}")
endforeach()

file(WRITE ${OUT}/phynness_relax.cpp "${made}#include \"phynness_image.h\"\n")
foreach(file include/phynness/schema/bounds.hpp src/core/arithmetic.hpp src/core/rbfn/exponential.hpp src/core/relax.cpp)
  read_part(${file} text)
  file(APPEND ${OUT}/phynness_relax.cpp "\n${text}")
endforeach()
