#!/bin/bash
# Makes the npm package and the page from a copy of this folder, and writes them into embedded_pages.cpp.
# Usage: build.sh SOURCE BUILD      BUILD/wasm contains phynness.wasm; BUILD/work and BUILD/out are made
set -euo pipefail
source=$1 build=$2
work=$build/work out=$build/out
mkdir -p "$work" "$out"

lock=$(cat "$source/package.json" "$source/package-lock.json" | cksum)
if [ ! -f "$work/node_modules/installed" ] || [ "$(cat "$work/node_modules/installed")" != "$lock" ]; then
  cp "$source/package.json" "$source/package-lock.json" "$source/.npmrc" "$work"
  if ! (cd "$work" && npm ci --no-progress --no-audit --no-fund --loglevel=error > "$build/npm.log" 2>&1); then
    echo "warning: the packages of web/package-lock.json cannot be installed: $(tail -n 3 "$build/npm.log" | tr '\n' ' ')" >&2
    echo "  remedy: give npm a registry (npm config set registry URL), and build again; without them phynness view" >&2
    echo "  is left out. All messages: $build/npm.log" >&2
    cp "$source/pages/no_files.cpp" "$build/embedded_pages.cpp"
    exit 0
  fi
  echo "$lock" > "$work/node_modules/installed"
fi

rm -rf "${work:?}"/{runtime,shared,view,tests}
cp -r "$source"/{runtime,shared,view,build.mjs,tsconfig.json} "$work"
cp -r "$source/../tests/web" "$work/tests"
cp "$source/../LICENSE" "$build"
cd "$work"
node build.mjs "$build/wasm/phynness.wasm" "$out" "$build/embedded_pages.cpp"
