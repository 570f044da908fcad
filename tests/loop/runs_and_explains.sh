#!/bin/sh
# Claims about the example: a slide, and two spheres of a body that come near, press and leave, have no status below 0, no
# unsettled cycle among those claimed and no change of force in a cycle above the limit below; closed paths and spheres
# without friction give the hand nothing; behind phn_loop the device trips with no family; wrong arguments are named.
# Usage: runs_and_explains.sh HAPTIC_LOOP WRITE_MODELS EXAMPLE_MODEL FOLDER
set -eu
loop=$1
example=$3
mkdir -p "$4"
cd "$4"
"$2" .

# Whether the summary on standard input has at most these: change of force [%], unsettled cycles, energy given [mJ].
within() {
  awk -v change="$1" -v unsettled="$2" -v given="$3" '
    { print }
    /largest change/ { force = $5; jump = $0; sub(/.*in a cycle /, "", jump); sub(/ .*/, "", jump) }
    /unsettled/ { n = $4 }
    /at most given/ { now = $0; sub(/.*at most given to it /, "", now); if (now + 0 > most) most = now + 0 }
    END { exit !(force > 0 && jump + 0 <= change && n <= unsettled && most + 0 <= given) }' ||
    { echo "expected at most $1 %, $2 cycles, $3 mJ"; exit 1; }
}

# One tool of a model: 1.3 and 0.7 % are the motion itself, at up to 100 mm/s; energies are rounding of the trapezoidal rule.
"$loop" "$example" closed --csv closed.csv | within 2 0 1e-4
"$loop" "$example" slide | within 1.5 0 0.01
# Two of a body that meet, held and as spheres, which behind springs have no edge at which one is felt alone.
"$loop" - same --body block/body.txt | within 2 0 1e-2
"$loop" - opposed --body block/body.txt --speed 0.02 | within 5 0 1
"$loop" - same --body block/body.txt --sphere 0.01 --csv spheres.csv | within 2 0 1e-3
# The last cycle of contact is 5 um deep, less than the motion in it.
"$loop" - same --body block/body.txt --sphere 0.01 --friction 0.5 | within 2 1 1e-3
# Behind the virtual coupling.
for motion in closed slide; do "$loop" "$example" $motion --device | tee device.txt | within 3 0 0.2; grep -q 'has not tripped' device.txt; done
# Two held tools, each behind its own loop, whose forces on the body may jump (100 %) until a loop has seen how stiff
# the other tool makes the body; some cycles are unsettled then. Without that, 1500 and more are, and the loops trip.
for held in same opposed pinch; do
  "$loop" - $held --body block/body.txt --device > device.txt || { cat device.txt; exit 1; }
  within 100 50 0.2 < device.txt
done
"$loop" - same --body block/body.txt --sphere 0.01 --device | tee device.txt
[ "$(grep -c 'has not tripped' device.txt)" -eq 2 ]

# A row for each tool and cycle, which the script draws.
[ "$(wc -l < closed.csv)" -eq $((1 + $("$loop" "$example" closed | sed -n 's/ cycles, largest.*//p'))) ]
if "$5" -c 'import matplotlib, numpy' 2> /dev/null; then
  "$5" "$6" spheres.csv spheres.png | grep 'back differs by'
  [ -s spheres.png ]
fi

refused() {
  expected=$1; words=$2; shift 2
  status=0
  said=$("$loop" "$@" 2>&1 >/dev/null) || status=$?
  echo "$said"
  [ $status -eq "$expected" ] && echo "$said" | grep -q -e "$words" || { echo "expected $expected: $words"; exit 1; }
}
refused 2 'usage' "$example"
refused 2 'no value' "$example" slide --csv
refused 2 'at: is more than 1 m from the surface' "$example" slide --at 25,0,0
refused 2 'depth: is more than 1 m' "$example" slide --depth 5
refused 2 'spere: is no option' "$example" slide --spere 0.01
refused 2 'X,Y,Z' "$example" slide --at 0.1
refused 2 'slide|closed' "$example" jump
refused 2 '\-\-speed' "$example" slide --speed 0
refused 1 'nowhere: neither a model.txt nor a folder with one' nowhere slide
refused 1 'nobody.txt: no file' "$example" same --body nobody.txt
refused 1 'body.txt: this is a body, and no model' block/body.txt slide
refused 1 'model.txt: this is a model, and no body' - slide --body "$example/model.txt"
refused 1 'body.txt: the body is of another mesh than .*model' "$example" same --body block/body.txt
refused 1 'one tool' round same
refused 1 'cannot be written' "$example" slide --csv nowhere/a.csv
