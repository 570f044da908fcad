#!/bin/bash
# Claims: phynness_image.h and phynness_image.cpp, alone in a folder, compile without warnings and without headers of C or C++
# libraries, for the host and for a Cortex-M4F and a Cortex-M7, and call nothing but loops over bytes, a square root and the
# compiler's own functions. A program of floats does not link with functions of doubles, nor the other way round.
# phynness::image is this file: the other tests here, under QEMU too, check its answers.
# Usage: pair_stands_alone.sh CC CXX FOLDER_OF_PAIR WORK_DIR
set -euo pipefail
cc=$1 cxx=$2 pair=$3 work=$4
rm -rf "$work"
mkdir -p "$work"
cp "$pair"/phynness_image.{h,cpp} "$work"
cd "$work"
flags=(-std=c++17 -O2 -ffreestanding -fno-exceptions -fno-rtti -fno-math-errno -ffp-contract=off -Wall -Wextra -Wpedantic -Wconversion
  -Wno-sign-conversion -Werror)
allowed='^(memcpy|memset|memmove|sqrt|__aeabi_[a-z0-9_]*|_GLOBAL_OFFSET_TABLE_|__stack_chk_fail)$'

# try COMPILER NM options...
try() {
  local compiler=$1 nm=$2 unknown
  shift 2
  "$compiler" "${flags[@]}" "$@" -c phynness_image.cpp -o image.o
  if "$compiler" "${flags[@]}" "$@" -M phynness_image.cpp | grep -F '/c++/'; then
    echo "$compiler: a header of the C++ library"
    exit 1
  fi
  unknown=$("$nm" -u image.o | awk '$1 == "U" {print $2}' | grep -Ev "$allowed" || true)
  [ -z "$unknown" ] || { echo "$compiler $*: calls $unknown"; exit 1; }
}
precisions=("" -DPHYNNESS_IMAGE_FLOAT)

cat > program.c <<'END'
#include "phynness_image.h"
int main(void) {
  const phn_image *image;
  return phn_image_open(0, 0, &image) == PHN_ERROR_ARGUMENT ? 0 : 1;
}
END
for library in "${precisions[@]}"; do
  # shellcheck disable=SC2086  # no word for doubles
  try "$cxx" nm $library
  for program in "${precisions[@]}"; do
    if "$cc" $program program.c image.o -o program 2> log.txt && ./program; then
      [ "$program" = "$library" ] || { echo "'$program' links with '$library'"; exit 1; }
    else
      [ "$program" != "$library" ] || { cat log.txt; exit 1; }
      grep -q phn_image log.txt
    fi
  done
done
if ! command -v arm-none-eabi-g++ > /dev/null; then
  echo "no arm-none-eabi-g++: not compiled for a device; tools/install-deps --devices installs it"
  exit 0
fi
try arm-none-eabi-g++ arm-none-eabi-nm -mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mfloat-abi=hard -DPHYNNESS_IMAGE_FLOAT
try arm-none-eabi-g++ arm-none-eabi-nm -mcpu=cortex-m7 -mfpu=fpv5-d16 -mfloat-abi=hard
