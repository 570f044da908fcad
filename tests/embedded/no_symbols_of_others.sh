#!/bin/bash
# Claim: code that evaluates images needs nothing but what every compiler may call for a loop over bytes.
# Usage: no_symbols_of_others.sh NM LIBRARY
set -euo pipefail
nm=$1
library=$2
allowed='^(memcpy|memset|memmove|_GLOBAL_OFFSET_TABLE_|__stack_chk_fail)$'
undefined=$("$nm" -u "$library" | awk '$1 == "U" {print $2}' | sort -u)
unknown=$(echo "$undefined" | grep -Ev "$allowed" | grep . || true)
if [ -n "$unknown" ]; then
  echo "images call what they must not:"
  echo "$unknown"
  exit 1
fi
defined=$("$nm" --defined-only "$library")
[[ $defined == *" T phn_imagef_force"* ]] || { echo "no phn_imagef_force in $library"; exit 1; }
