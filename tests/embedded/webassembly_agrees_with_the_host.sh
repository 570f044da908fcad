#!/bin/bash
# Claims: the whole runtime compiled to WebAssembly has no import and at most 152 kB (its answers: web/runtime/test); images of
# floats have the host's bits there, in at most 9 kB.
# Usage: webassembly_agrees_with_the_host.sh CMAKE WASM_SOURCE PHYNNESS WRITE_MODELS WORK_DIR     (77: tools are absent)
set -euo pipefail
cmake=$1
source=$2
phynness=$3
write_models=$4
work=$5
skip() { echo "skipped: $1; tools/install-deps --devices installs it"; exit 77; }
for tool in clang++ wasm-ld node; do command -v "$tool" > /dev/null || skip "no $tool"; done
mkdir -p "$work"
printf '#include <cmath>\nint main() { return 0; }\n' > "$work/try.cpp"
clang++ --target=wasm32-wasi -c "$work/try.cpp" -o "$work/try.o" 2> /dev/null || skip "no libc++ or wasi-libc for wasm32"
command -v make > /dev/null || export CMAKE_GENERATOR=Ninja
rm -rf "$work"
"$write_models" "$work/models"
"$cmake" -S "$source" -B "$work/build" -DCMAKE_TOOLCHAIN_FILE=wasm32-wasi.cmake -DPHYNNESS_WARNINGS_AS_ERRORS=ON \
  > "$work/log.txt" 2>&1 || { cat "$work/log.txt"; exit 1; }
"$cmake" --build "$work/build" >> "$work/log.txt" 2>&1 || { cat "$work/log.txt"; exit 1; }
failed=0
for family in rbfn linear modal; do
  echo "$family"
  "$phynness" export "$work/models/$family" -o "$work/$family" --float --golden 256 --json "$work/golden.json" \
    > "$work/log.txt"
  node "$source/check.mjs" "$work/build/force.wasm" "$work/$family/model.bin" "$work/golden.json" || failed=1
done
node "$source/check_loop.mjs" "$work/build/loop.wasm" || failed=1
limit() {
  local bytes
  bytes=$(stat -c %s "$work/build/$1")
  echo "$1: $bytes bytes, limit $2"
  [ "$bytes" -le "$2" ] || { echo "FAILED: $1 is too large"; failed=1; }
}
if command -v wasm-opt > /dev/null; then limit phynness.wasm 155648; else echo "size not checked: no wasm-opt"; fi
limit force.wasm 9216
limit loop.wasm 20480
exit "$failed"
