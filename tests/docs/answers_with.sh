#!/usr/bin/env bash
# Runs a command and requires its exit status and a line that matches, which ctest cannot require both.
# Usage: answers_with.sh STATUS REGEX COMMAND...
set -u
wanted=$1 pattern=$2
shift 2
output=$("$@" 2>&1)
status=$?
printf '%s\n' "$output"
[ "$status" -eq "$wanted" ] || { echo "exit status $status, not $wanted" >&2; exit 1; }
grep -Eq -- "$pattern" <<< "$output" || { echo "no line matches $pattern" >&2; exit 1; }
