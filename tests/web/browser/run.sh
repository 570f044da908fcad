#!/bin/bash
# Claims: the tests beside this file hold in a browser.
# Usage: run.sh BROWSER PHYNNESS WRITE_MODELS SOURCE_DIR BUILD_DIR     (chromium, firefox or webkit)
# Exit status 77 if the browser is not installed, unless the environment variable CI is set: then it fails.
set -euo pipefail
export PHYNNESS_BROWSER=$1 PHYNNESS=$2 PHYNNESS_PACKAGE=$5/out/phynness PHYNNESS_WRITE_MODELS=$3 PHYNNESS_SOURCE=$4 PHYNNESS_SAMPLE_MODEL=$4/examples/model
build=$5
case $1 in
  chromium) programs=(chromium google-chrome) ;;
  firefox) programs=(firefox-esr firefox) ;;
  webkit) programs=(WebKitWebDriver) ;;
esac
if ! command -v "${programs[@]}" > /dev/null && [ -z "${CI:-}" ]; then
  echo "skipped: $1 is not installed; tools/install-deps --tests --devices installs it"
  exit 77
fi
cd "$build/work"
screen=()
[ "$1" = chromium ] || screen=(env LIBGL_ALWAYS_SOFTWARE=1 xvfb-run --auto-servernum --server-args '-screen 0 1400x1000x24')
# Its sandbox needs rights that a container does not have; the page is our own.
[ "$1" != webkit ] || exec env WEBKIT_DISABLE_SANDBOX_THIS_IS_DANGEROUS=1 "${screen[@]}" node tests/browser/webkit.mjs "$PHYNNESS_SOURCE/docs/liver.html" "$build/out/phynness"
exec "${screen[@]}" node_modules/.bin/vitest run --config tests/vitest.config.ts
