#!/bin/sh
# Claim: the example runs a model of each family to its report, and says what is wrong with wrong arguments.
# Usage: runs_and_explains.sh HAPTIC_LOOP WRITE_MODELS FOLDER
set -eu
loop=$1
mkdir -p "$3"
cd "$3"
"$2" .
for model in rbfn linear modal; do
  out=$("$loop" "$model" --node 3 --cycles 5000 --latency 2 --coupling 800)
  echo "$out"
  echo "$out" | grep -q '5000 cycles'
  echo "$out" | grep -q 'has not tripped'
done
out=$("$loop" modal --node 3 --cycles 5000 --contact 1 --radius 0.003 --friction 0.3 --reach 0.05)
echo "$out"
echo "$out" | grep -Eq 'touching in [1-9][0-9]*,'
# 20 ms at 1 kHz with both ends, however many steps the file has.
motion='{"format": "phynness motion 1", "tools": [{"node": 3}], "time_s": [5, 5.016, 5.02], '
echo "$motion"'"displacement_m": [[[0, 0, 0]], [[0, 0, -0.001]], [[0.001, 0, -0.001]]]}' > motion.json
out=$("$loop" modal --node 3 --motion motion.json)
echo "$out"
echo "$out" | grep -q '21 cycles'
# A trip is an exit status.
echo '{"format": "phynness motion 1", "tools": [{"node": 3}], "time_s": [0, 0.001, 0.003], "displacement_m": [
  [[0, 0, 0]], [[0, 0, 0]], [[0, 0, 0.1]]]}' > jump.json
status=0
out=$("$loop" modal --node 3 --motion jump.json 2>&1) || status=$?
echo "$out"
[ $status -eq 3 ] && echo "$out" | grep -q 'jumped by more than'
refused() {
  expected=$1; words=$2; shift 2
  status=0
  said=$("$loop" "$@" 2>&1 >/dev/null) || status=$?
  echo "$said"
  [ $status -eq "$expected" ] && echo "$said" | grep -q -e "$words" || { echo "expected $expected: $words"; exit 1; }
}
refused 2 'model directory' --node 3
refused 2 '--cycles needs a whole number' modal --node 3 --cycles -1
refused 2 '--node needs a whole number' modal --node 3.7
refused 2 '--damping needs a number from 0 to 100' modal --node 3 --damping 1e9
refused 2 '--latency needs a whole number from 0 to 100' modal --node 3 --latency 101
refused 2 'unknown option --radios' modal --node 3 --radios 1
refused 1 'phynness train' nowhere --node 3
refused 1 'node 1' modal --node 1
refused 1 'node 15' modal --node 15 --contact 1
refused 1 '--coupling' modal --node 3 --coupling 0
echo "$motion"'"displacement_m": [[[0, 0, 0]], [null], [[0, 0, 0]]]}' > motion.json
refused 1 'motion.json: step 1: the tool lets go' modal --node 3 --motion motion.json
echo "$motion" > motion.json
refused 1 'motion.json:2: the file is not valid JSON' modal --node 3 --motion motion.json
