#!/bin/bash
# Claim: the library needs no heap, no exceptions, no files, no output, no locale. Every symbol that it leaves to others
# is on the short list below: a new one fails this test until somebody has thought about it.
# Usage: no_forbidden_symbols.sh NM LIBRARY
set -euo pipefail
nm=$1
library=$2
allowed='^(exp|frexp|ldexp|sqrt|fmax|fmin|memcmp|memcpy|memset|memmove|strlen|__cpu_model|_GLOBAL_OFFSET_TABLE_|__stack_chk_fail)$'
undefined=$("$nm" -u "$library" | awk '$1 == "U" {print $2}' | sort -u)
defined=$("$nm" --defined-only "$library" | awk 'NF == 3 {print $3}' | sort -u)
unknown=$(comm -23 <(echo "$undefined") <(echo "$defined") | grep -Ev "$allowed" || true)
if [ -n "$unknown" ]; then
  echo "the runtime calls what it must not:"
  echo "$unknown"
  exit 1
fi
[ -n "$undefined" ] || { echo "nm found no symbols at all in $library"; exit 1; }
