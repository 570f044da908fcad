#!/bin/bash
# Claims: the tests beside this file hold in a browser.
# Usage: run.sh BROWSER PHYNNESS SOURCE_DIR BUILD_DIR     (chromium or firefox)
# Exit status 77 if the browser is not installed, unless the environment variable CI is set: then it fails.
set -euo pipefail
export PHYNNESS_BROWSER=$1 PHYNNESS=$2 PHYNNESS_SOURCE=$3 PHYNNESS_SAMPLE_MODEL=$3/examples/model
build=$4
case $1 in
  chromium) programs=(chromium google-chrome) ;;
  firefox) programs=(firefox-esr firefox) ;;
esac
if ! command -v "${programs[@]}" > /dev/null && [ -z "${CI:-}" ]; then
  echo "skipped: $1 is not installed; tools/install-deps --tests --devices installs it"
  exit 77
fi
cd "$build/work"
screen=()
[ "$1" = chromium ] || screen=(env LIBGL_ALWAYS_SOFTWARE=1 xvfb-run --auto-servernum --server-args '-screen 0 1400x1000x24')
exec "${screen[@]}" node_modules/.bin/vitest run --config browser_tests/vitest.config.ts
