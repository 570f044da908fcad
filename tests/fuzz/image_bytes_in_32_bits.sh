#!/bin/bash
# Claim: the checks of images hold where size_t has 32 bits. The fuzz target image_bytes is built with -m32 and the
# sanitizers of addresses and undefined behaviour, and runs changed images of all families.
# Usage: image_bytes_in_32_bits.sh CXX SOURCE PHYNNESS WRITE_MODELS WORK_DIR     (77: there is no 32-bit C++ library)
set -euo pipefail
cxx=$1 source=$2 phynness=$3 write_models=$4 work=$5
rm -rf "$work"
mkdir -p "$work"
cd "$work"
flags=(-m32 -std=c++20 -O1 -g -fsanitize=address,undefined -fno-sanitize-recover=all)
echo 'int main() { return sizeof(void*) == 4 ? 0 : 1; }' > probe.cpp
if ! { "$cxx" "${flags[@]}" probe.cpp -o probe && ./probe; } > log.txt 2>&1; then
  echo "skipped: no 32-bit programs with sanitizers; tools/install-deps --tests installs the library on x86-64"
  exit 77
fi

"$write_models" models
for family in rbfn linear modal round; do
  for option in '' --float; do
    "$phynness" export models/$family -o "$family$option" $option > log.txt
    # Prologue: seal the image; its kind of number.
    { printf "\\x$([ "$option" = "" ] && echo 1 || echo 3)"; head -c 15 /dev/zero; cat "$family$option"/*.bin; } > "seed-$family$option"
  done
done
flags+=(-I "$source"/runtime/include -I "$source"/runtime/src)
for part in image open; do "$cxx" "${flags[@]}" -DPHYNNESS_IMAGE_FLOAT -c "$source/runtime/src/image/$part.cpp" -o $part-float.o; done
"$cxx" "${flags[@]}" "$source"/runtime/src/image/{image,open}.cpp image-float.o open-float.o \
  "$source"/tests/fuzz/{image_bytes,plain_main}.cpp -o fuzz_32
./fuzz_32 20000 seed-*
