# Writes phynness_image.h and phynness_image.cpp into OUT: the evaluation of images as two files that need no others. They
# consist of the files of SOURCES in their order, without the includes of each other; of phynness.h only the statuses
# and phn_provenance are taken. Usage: cmake -DRUNTIME=... -DOUT=... -DVERSION=... "-DSOURCES=a;b" -P image_pair.cmake
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
read_part(include/phynness/phynness_image.h image)
string(REPLACE "#define PHYNNESS_IMAGE_H\n" "#define PHYNNESS_IMAGE_H\n\n${api}\n${statuses}\n${provenance}" image "${image}")
file(WRITE ${OUT}/phynness_image.h "${made}${image}")

file(WRITE ${OUT}/phynness_image.cpp "${made}#include \"phynness_image.h\"\n")
foreach(file IN LISTS SOURCES)
  read_part(${file} text)
  file(APPEND ${OUT}/phynness_image.cpp "\n${text}")
endforeach()
