#!/bin/bash
# Claims: bindings/csharp has the bits of phynness::Organ, in a model, a body and both, and the statuses of phynness.h; the
# claims of Answers.cs and UnityStubs.cs hold; a library of another version is refused with both versions.
# Usage: run.sh MCS MONO CC ANSWERS WRITE_MODELS SOURCE_DIR LIBRARY_DIR BUILD_DIR
set -euo pipefail
mcs=$1 mono=$2 cc=$3 answers=$4 write_models=$5 source=$6 libraries=$7 build=$8
fail() {
  echo "FAILED: $1" >&2
  exit 1
}
rm -rf "$build"
mkdir -p "$build/other"
cd "$build"
"$write_models" "$build"
binding=$source/bindings/csharp/Phynness.cs
"$mcs" -warn:4 -warnaserror -out:Answers.exe "$binding" "$source"/examples/unity/{LeftHanded,HapticThread}.cs "$source/tests/csharp/Answers.cs"
"$mcs" -warnaserror -nowarn:649 -define:UNITY_5_3_OR_NEWER -out:Unity.exe "$binding" "$source"/examples/unity/*.cs \
  "$source/tests/csharp/UnityStubs.cs" || fail "the example for Unity does not compile"
export LD_LIBRARY_PATH=$libraries
for organ in "$source/examples/model -" "round -" "block block/body.txt" "- block/body.txt"; do
  # shellcheck disable=SC2086
  "$answers" $organ > c++.txt
  # shellcheck disable=SC2086
  "$mono" Answers.exe $organ > csharp.txt
  [ "$(wc -l < c++.txt)" -gt 1900 ] || fail "only $(wc -l < c++.txt) answers of $organ"
  diff c++.txt csharp.txt > differences.txt || fail "C# and C++ differ for $organ: $(head -n 3 differences.txt)"
done
# Numbers of statuses stand in both languages: PHN_ERROR_NOT_ACTIVE = -2 is ErrorNotActive = -2.
while read -r name value; do
  name=$(sed -E 's/(^|_)([A-Z])([A-Z]*)/\2\L\3/g' <<< "${name#PHN_}")
  grep -qE "^  ${name#Warning} = $value,?\$" "$binding" || fail "Phynness.cs has no ${name#Warning} = $value"
done < <(grep -oE '^  PHN_(WARNING|ERROR)_[A-Z_]+ = -?[0-9]+' "$source/runtime/include/phynness/phynness.h" | tr -d '=')
"$mono" Answers.exe "$source/examples/model" - --claims || fail "claims of Answers.cs"
"$mono" Unity.exe "$build/block" || fail "claims of UnityStubs.cs"

echo 'int phn_abi_version(void) { return 99; }' > other.c
"$cc" -shared -fPIC -o other/libphynness.so other.c
! LD_LIBRARY_PATH=$build/other "$mono" Answers.exe "$source/examples/model" - > refused.txt 2>&1 || fail "a library of another version is used"
grep -q "the interface is 99 in the library phynness and 1 in Phynness.cs" refused.txt || fail "the reason is not said: $(head -n 3 refused.txt)"
