#!/bin/bash
# Claims: the library needs no heap, no exceptions, no files, no output, no locale. Every symbol that it leaves to others is on
# the short list below: a new one fails this test until somebody has thought about it. Global symbols for C are the functions of
# the headers, under the names of the library's precision; a shared library shows these and nothing else, is not larger than a
# budget and needs no library but C's.
# Usage: no_forbidden_symbols.sh NM LIBRARY HEADERS_FOLDER PREFIX [HEADER ...]     (default: those of the runtime)
set -euo pipefail
nm=$1 library=$2 headers=$3 prefix=$4
shift 4
[ $# -gt 0 ] || set -- phynness.h phynness_tools.h phynness_surface.h phynness_contact.h phynness_body.h
fail() { echo "$library: $*"; exit 1; }
shared=()
[[ $library == *.so* ]] && shared=(-D)
# 584 kB of 64-bit code and tables for three instruction sets, and a hundredth. Force, energy and stiffness in one pass are
# 28 kB of it, means under round tools and bounds of coupled tools 14 kB, derivatives of the laws 63 kB, reduced bodies 84 kB.
largest_bytes=600000

allowed='^(frexp|ldexp|sqrt|trunc|fmax|fmin|memcmp|memcpy|memset|memmove|strcmp|strlen|__cpu_model|_GLOBAL_OFFSET_TABLE_|__stack_chk_fail)$'
undefined=$("$nm" "${shared[@]}" -u "$library" | awk '$1 == "U" {sub("@.*", "", $2); print $2}' | sort -u)
defined=$("$nm" "${shared[@]}" --defined-only "$library" | awk 'NF == 3 {print $3}' | sort -u)
unknown=$(comm -23 <(echo "$undefined") <(echo "$defined") | grep -Ev "$allowed" || true)
[ -z "$unknown" ] || fail "calls what it must not: $unknown"
[ -n "$undefined" ] || fail "nm found no symbols at all"

declared=$(cd "$headers" && sed -n 's/^PHN_API .*\bphn_\([a-z_]*\)(.*/\1/p' "$@" | sed "s/^/$prefix/" | sort -u)
functions=$("$nm" "${shared[@]}" -g --defined-only "$library" | awk '$2 == "T" && $3 !~ /^_Z/ {print $3}' | sort -u)
[ "$functions" = "$declared" ] || fail "functions and headers differ: $(diff <(echo "$functions") <(echo "$declared") || true)"
[ "${#shared[@]}" -gt 0 ] || exit 0

others=$(comm -23 <(echo "$defined") <(echo "$functions"))
[ -z "$others" ] || fail "shows more than the interface: $others"
bytes=$(stat -L -c %s "$library")
[ "$bytes" -le "$largest_bytes" ] || fail "$bytes bytes, more than $largest_bytes"
if command -v readelf > /dev/null; then
  readelf -d "$library" | grep -q 'SONAME.*libphynness.*\.so\.[0-9]*\.[0-9]*\]' || fail "has no SONAME with a version"
  foreign=$(readelf -d "$library" | sed -n 's/.*NEEDED.*\[\(.*\)\]/\1/p' | grep -vE '^(libm|libc|ld-linux.*)\.so' || true)
  [ -z "$foreign" ] || fail "needs $foreign"
fi
