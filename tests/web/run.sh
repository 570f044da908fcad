#!/bin/bash
# Claims: the tests beside this file hold; the package is installed from its archive into another project, where its
# types work; and it loads in Node without an option.
# Usage: run.sh PHYNNESS WRITE_MODELS SOURCE_DIR BUILD_DIR
set -euo pipefail
phynness=$1 write_models=$2 source=$3 build=$4
fail() {
  echo "FAILED: $1" >&2
  exit 1
}
export PHYNNESS=$phynness PHYNNESS_MODELS=$build/models PHYNNESS_PACKAGE=$build/out/phynness PHYNNESS_WASM=$build/wasm/phynness.wasm
mkdir -p "$build/models"
"$write_models" "$build/models"
bytes=$(stat -c %s "$PHYNNESS_WASM")
[ "$bytes" -le 180000 ] || fail "phynness.wasm has $bytes bytes instead of at most 180,000"
rm -rf "$build/models/sample"
cp -r "$source/examples/model" "$build/models/sample"
cd "$build/work"
node_modules/.bin/tsc --noEmit || fail "the types are wrong"
node_modules/.bin/vitest run --config tests/vitest.config.ts

rm -rf "$build/user"
mkdir -p "$build/user"
cd "$build/user"
echo '{"type": "module", "private": true}' > package.json
archive=$(cd "$PHYNNESS_PACKAGE" && npm pack --silent --pack-destination "$build/user")
npm install --silent --no-progress --offline "./$archive"
cat > press.mjs <<'JS'
import { readFileSync } from 'node:fs';
import { modelFromText } from 'phynness';
const model = await modelFromText(readFileSync(process.argv[2]));
console.log(model.force(model.info.activeNodes[0], [0, 0, -0.01]).force.length);
JS
[ "$(node press.mjs "$build/models/sample/model.txt")" = 3 ] || fail "a program that uses the package has no force"
cat > use.ts <<'TS'
import { modelFromText, PhynnessError, type Response } from 'phynness';
const model = await modelFromText('');
const response: Response = model.force(1, [0, 0, 0], { energy: true });
export const force: Float64Array = response.force;
export const status: number | undefined = new PhynnessError(-1, '', '').wrongByte;
TS
"$build/work/node_modules/.bin/tsc" --noEmit --strict --module nodenext --target es2022 --skipLibCheck use.ts ||
  fail "a program that uses the types does not compile"
echo "the package works in another project"
