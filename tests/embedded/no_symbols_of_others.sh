#!/bin/bash
# Claim: code that evaluates images needs nothing but what every compiler may call for a loop over bytes.
# Usage: no_symbols_of_others.sh NM LIBRARY_OF_DOUBLES LIBRARY_OF_FLOATS
set -euo pipefail
nm=$1
allowed='^(memcpy|memset|memmove|_GLOBAL_OFFSET_TABLE_|__stack_chk_fail)$'
# check LIBRARY FUNCTION
check() {
  local unknown
  unknown=$("$nm" -u "$1" | awk '$1 == "U" {print $2}' | sort -u | grep -Ev "$allowed" | grep . || true)
  [ -z "$unknown" ] || { echo "$1 calls what it must not: $unknown"; exit 1; }
  [[ $("$nm" --defined-only "$1") == *" T $2"* ]] || { echo "no $2 in $1"; exit 1; }
}
check "$2" phn_image_force
check "$3" phn_imagef_force
