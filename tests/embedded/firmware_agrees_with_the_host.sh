#!/bin/bash
# Claims, on a Cortex-M4F and a Cortex-M7 in QEMU: every golden query has the bits that the same image has on the host and
# is as near to the runtime's double as examples/firmware/main.c states; a force of 60 neurons at a node takes less than 5,000
# instructions, the code that forces need less than 7.5 kB of flash, no RAM but the stack. With deformations it is 9.5 kB, with
# places and bounds 15.5 kB and 3 kB of stack; a walk to the next place takes less than 5,000 instructions.
# Usage: firmware_agrees_with_the_host.sh CMAKE FIRMWARE_SOURCE PHYNNESS WRITE_MODELS WORK_DIR     (77: tools are absent)
set -euo pipefail
cmake=$1 source=$2 phynness=$3 write_models=$4 work=$5
for tool in arm-none-eabi-g++ arm-none-eabi-nm qemu-system-arm; do
  command -v "$tool" > /dev/null || { echo "skipped: no $tool; tools/install-deps --devices installs it"; exit 77; }
done
command -v make > /dev/null || export CMAKE_GENERATOR=Ninja
rm -rf "$work"
"$write_models" "$work/models"

failed=0
limit() {  # NAME VALUE LIMIT
  echo "  $1 $2, limit $3"
  [ "$2" -le "$3" ] || { echo "FAILED: $1"; failed=1; }
}
figure() { awk -v name="$1" '$1 == name {print $2}' "$work/out.txt"; }

# try CORTEX BOARD MODEL LIMIT_OF_INSTRUCTIONS [options of export]
try() {
  local cortex=$1 board=$2 family=$3 most=$4 build="$work/$1" options=("${@:5}")
  local exported="$work/$family${options[*]//[- ]/_}"
  echo "$board $family ${options[*]}"
  "$phynness" export "$work/models/$family" -o "$exported" --golden 256 "${options[@]}" > "$work/log.txt"
  "$cmake" -S "$source" -B "$build" -DCMAKE_TOOLCHAIN_FILE=cortex-m.cmake -DCORTEX="$cortex" -DMODEL="$exported" \
    -DPHYNNESS_WARNINGS_AS_ERRORS=ON > "$work/log.txt" 2>&1 || { cat "$work/log.txt"; exit 1; }
  "$cmake" --build "$build" >> "$work/log.txt" 2>&1 || { cat "$work/log.txt"; exit 1; }
  timeout 120 qemu-system-arm -M "$board" -icount shift=0 -nographic -monitor none -serial null -semihosting \
    -kernel "$build/firmware.elf" > "$work/out.txt" 2>&1 < /dev/null || { echo "FAILED: exit status $?"; failed=1; }
  sed 's/^/  /' "$work/out.txt"
  [ -n "$(figure force_at_node_instructions_at_most)" ] || { echo "FAILED: no figures"; exit 1; }
  limit "instructions of a force at a node" "$(figure force_at_node_instructions_at_most)" "$most"
  local code ram
  code=$(arm-none-eabi-nm -S "$build/firmware.elf" | awk '$3 ~ /[tTwW]/ && $4 ~ /^phn_|phynness|_GLOBAL__N_1/ {
    n = 0; for (i = 1; i <= length($2); ++i) n = 16 * n + index("0123456789abcdef", substr($2, i, 1)) - 1; sum += n } END {print sum}')
  ram=$(arm-none-eabi-size "$build/firmware.elf" | awk 'NR == 2 {print $2 + $3}')
  if [ "$family" = round ]; then
    limit "bytes of code" "$code" 15872
    for use in force_between bound_between walk; do limit "bytes of stack of $use" "$(figure ${use}_stack)" 3072; done
    limit "instructions of a walk" "$(figure walk_instructions_at_most)" 5000
  else
    limit "bytes of code" "$code" $([[ ${options[*]} == *--force-only* ]] && echo 7680 || echo 9728)
  fi
  limit "bytes of static RAM" "$ram" $((16 + $(awk '$2 ~ /RAM_BYTES$/ {print $3}' "$exported/model.h")))
}

try m4f mps2-an386 rbfn 5000 --float
try m4f mps2-an386 rbfn 5000 --float --force-only
try m4f mps2-an386 modal 5000 --float
try m4f mps2-an386 linear 1000 --float
try m7 mps2-an500 rbfn 7000
try m7 mps2-an500 modal 5000
try m7 mps2-an500 modal 5000 --float --force-only
try m7 mps2-an500 linear 1000
try m4f mps2-an386 round 5000 --float
try m7 mps2-an500 round 5000
exit "$failed"
