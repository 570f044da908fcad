#!/bin/bash
# Claims: what `phynness export` writes is C that a strict compiler takes, its constants are the image's sizes, the
# array is the file; wrong usage and input exit with 2 and say what to do, and leave nothing behind.
# Usage: export_keeps_its_contract.sh PHYNNESS WRITE_MODELS CC INCLUDE_DIR LIBRARY LIBRARY_OF_FLOATS WORK_DIR
set -euo pipefail
phynness=$1 write_models=$2 cc=$3 include=$4 doubles=$5 floats=$6 work=$7
rm -rf "$work"
"$write_models" "$work/models"
fail() { echo "FAILED: $*"; exit 1; }

for family in rbfn linear modal; do
  for options in "" "--float" "--force-only" "--float --force-only"; do
    exported="$work/$family${options//[- ]/_}"
    # shellcheck disable=SC2086  # several words
    "$phynness" export "$work/models/$family" -o "$exported" --name liver_2 --golden 40 $options \
      --json "$work/sizes.json" > "$work/log.txt"
    cat > "$work/main.c" <<'END'
#include <phynness/phynness_image.h>
#include <stdio.h>
#include <string.h>
#include "liver_2.h"
#include "liver_2_golden.h"

static unsigned char file[LIVER_2_IMAGE_BYTES + 1];

int main(int argc, char **argv) {
  FILE *in = argc == 2 ? fopen(argv[1], "rb") : NULL;
  if (in == NULL || fread(file, 1, sizeof file, in) != LIVER_2_IMAGE_BYTES) return 1;
  if (memcmp(file, liver_2_image, LIVER_2_IMAGE_BYTES) != 0) return 2;
  for (int i = 0; i < LIVER_2_GOLDEN; ++i) {
    const struct liver_2_query *q = &liver_2_golden[i];
    const phn_image *image;
    phn_image_contents contents;
    phn_image_tool tool;
    phn_real d[3], f[3];
    double force[3];
    int status;
    for (int k = 0; k < 3; ++k) d[k] = (phn_real)q->displacement[k];
    if (phn_image_open(liver_2_image, sizeof liver_2_image, &image) != PHN_OK) return 3;
    if (phn_image_info(image, &contents) != PHN_OK || contents.n_output != LIVER_2_OUTPUT ||
        contents.scratch_bytes != LIVER_2_SCRATCH * sizeof(phn_real)) return 4;
    tool = phn_image_tool_at(q->node, d);
    status = phn_image_force(image, &tool, f);
    for (int k = 0; k < 3; ++k) force[k] = (double)f[k];
    if (status != q->status || memcmp(force, q->image_force, sizeof force) != 0) return 5;
  }
  return fclose(in);
}
END
    precision=("$doubles")
    [[ $options != *--float* ]] || precision=("$floats" -DPHYNNESS_IMAGE_FLOAT)
    "$cc" -std=c99 -Wall -Wextra -Wpedantic -Werror -I "$include" -I "$exported" "$work/main.c" "$exported/liver_2.c" \
      "$exported/liver_2_golden.c" "${precision[@]}" -o "$work/program"
    "$work/program" "$exported/liver_2.bin" || fail "$family $options: program says $?"
    grep -q '"force_deviation"' "$work/sizes.json" || fail "no force_deviation in the JSON"
  done
done

# refuse WORDS options...: exit status 2, the words on stderr, no output.
refuse() {
  local words=$1 status=0
  shift
  "$phynness" export "$@" > /dev/null 2> "$work/err.txt" || status=$?
  [ "$status" -eq 2 ] || fail "export $*: exit status $status"
  grep -q -- "$words" "$work/err.txt" || fail "export $*: $(cat "$work/err.txt")"
  [ ! -e "$work/out" ] || fail "export $*: wrote something"
}
good="$work/models/rbfn"
refuse "letters, digits and _" "$good" -o "$work/out" --name 2fast
refuse "letters, digits and _" "$good" -o "$work/out" --name "a-b"
refuse "model.txt" "$work/nowhere" -o "$work/out"
refuse "--output" "$good"
refuse "of the model itself" "$good" -o "$good/."
refuse "would overwrite" "$good" -o "$work/out" --json "$good/model.txt"
refuse "100000" "$good" -o "$work/out" --golden 100001
: > "$work/file"
refuse "$work/file" "$good" -o "$work/file"
cp -r "$good" "$work/damaged"
sed -i 's/^family rbfn/family rbfm/' "$work/damaged/model.txt"
refuse "remedy" "$work/damaged" -o "$work/out"
