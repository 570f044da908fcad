#!/bin/sh
# Claim: the example runs a model of each family to its report, a trip is an exit status, and wrong arguments are named.
# Usage: runs_and_explains.sh HAPTIC_LOOP WRITE_MODELS FOLDER
set -eu
loop=$1
mkdir -p "$3"
cd "$3"
"$2" .
for model in rbfn linear modal; do
  out=$("$loop" $model/model.txt 3 5)
  echo "$out"
  echo "$out" | grep -q '5000 cycles, largest force 0*\.*0*[1-9]'
  echo "$out" | grep -q 'has not tripped'
done
refused() {
  expected=$1; words=$2; shift 2
  status=0
  said=$("$loop" "$@" 2>&1 >/dev/null) || status=$?
  echo "$said"
  [ $status -eq "$expected" ] && echo "$said" | grep -q -e "$words" || { echo "expected $expected: $words"; exit 1; }
}
refused 2 'usage' modal/model.txt
refused 1 'phynness train' nowhere 3
refused 1 '1: ' modal/model.txt 1
