#!/usr/bin/env bash
# Claim: no source file of the runtime compiles with -ffast-math, -Ofast or a part of them that the compiler announces
# by a macro, and its CMake project refuses them. The message names the remedy. Files that only include the public
# headers compile.
# Usage: fast_math_is_refused.sh COMPILER CMAKE RUNTIME_FOLDER WORK_FOLDER
set -euo pipefail
compiler=$1 cmake=$2 runtime=$3 work=$4
message="phynness: .*-fno-fast-math"
# At the first error, which is the refusal.
check=(-std=c++17 -fsyntax-only -Wfatal-errors -DPHYNNESS_VERSION='"x"' "-I$runtime/include" "-I$runtime/src")
fail() { echo "$*" >&2; exit 1; }

rm -rf "$work"
mkdir -p "$work"
for source in "$runtime"/src/{core,tools,contact,surface,image}/*.cpp; do
  if "$compiler" "${check[@]}" -ffast-math "$source" 2> "$work/said"; then
    fail "$source compiles with -ffast-math: include core/arithmetic.hpp"
  fi
  grep -q -- "$message" "$work/said" || fail "$source is refused without a remedy: $(cat "$work/said")"
done

# The last flag can revoke those before it.
source=$runtime/src/core/phynness.cpp
for flags in -Ofast -ffinite-math-only "-fno-fast-math -ffinite-math-only"; do
  # shellcheck disable=SC2086
  ! "$compiler" "${check[@]}" $flags "$source" 2> "$work/said" || fail "$flags is accepted"
  grep -q -- "$message" "$work/said" || fail "$flags is refused without a remedy"
done
"$compiler" "${check[@]}" -ffast-math -fno-fast-math "$source" || fail "-ffast-math is not taken back"
if ! "$compiler" --version | grep -q clang; then
  for flags in -funsafe-math-optimizations -fno-signed-zeros "-fassociative-math -fno-signed-zeros -fno-trapping-math"; do
    # shellcheck disable=SC2086
    ! "$compiler" "${check[@]}" $flags "$source" 2> "$work/said" || fail "$flags is accepted"
  done
fi

for header in phynness/phynness.h phynness/phynness_contact.h phynness/phynness_image.h phynness/phynness.hpp; do
  echo "#include <$header>" > "$work/user.cpp"
  "$compiler" -std=c++17 -fsyntax-only -ffast-math "-I$runtime/include" "$work/user.cpp" || fail "$header is refused"
done

for flags in -ffast-math -Ofast "-O2 -fassociative-math" -fno-signed-zeros; do
  if "$cmake" -S "$runtime" -B "$work/build" "-DCMAKE_CXX_COMPILER=$compiler" "-DCMAKE_CXX_FLAGS=$flags" \
    > "$work/said" 2>&1; then
    fail "the CMake project accepts $flags"
  fi
  grep -q "phynness: .*${flags##* }" "$work/said" || fail "CMake does not name $flags: $(cat "$work/said")"
  rm -rf "$work/build"
done
