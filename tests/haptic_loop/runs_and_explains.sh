#!/bin/sh
# Claim: the example runs a model of each family to its report, and says what is wrong with wrong arguments.
# Usage: runs_and_explains.sh HAPTIC_LOOP WRITE_MODELS FOLDER
set -eu
loop=$1
mkdir -p "$3"
cd "$3"
"$2" .
for model in rbfn linear modal; do
  out=$("$loop" "$model" --node 3 --cycles 20000 --free --stall 500,30)
  echo "$out"
  echo "$out" | grep -q '20000 cycles'
  echo "$out" | grep -Eq 'zero for 2[0-9] cycles with stale positions'
done
printf '0 0 0\n0.001 0 -0.002\n' > motion.txt
"$loop" modal --node 3 --cycles 100 --motion motion.txt | grep -q 'missed deadlines'
out=$("$loop" modal --node 3 --cycles 5000 --free --contact --radius 0.003 --friction 0.3)
echo "$out"
echo "$out" | grep -Eq '^contact +[0-9]+ touches, [0-9.]+ % of the cycles'
refused() {
  expected=$1; words=$2; shift 2
  status=0
  said=$("$loop" "$@" 2>&1 >/dev/null) || status=$?
  echo "$said"
  [ $status -eq "$expected" ] && echo "$said" | grep -q "$words" || { echo "expected $expected: $words"; exit 1; }
}
refused 2 'model directory' --node 3
refused 2 'positive number' modal --node 3 --cycles -1
refused 1 'phynness train' nowhere --node 3
refused 1 'node 1' modal --node 1
refused 2 'radius' modal --node 3 --radius 0.01
refused 2 'positive number' modal --node 3 --contact --friction -0.5
refused 2 'node 15' modal --node 15 --contact
printf '0 0 up\n' > motion.txt
refused 1 'motion.txt:1' modal --node 3 --motion motion.txt
