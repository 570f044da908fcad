#!/bin/bash
# Claims: the tests beside this file hold in a browser.
# Usage: run.sh BROWSER PHYNNESS WRITE_MODELS SOURCE_DIR BUILD_DIR     (chromium or firefox)
# Exit status 77 if the browser is not installed, unless the environment variable CI is set: then it fails.
set -euo pipefail
export PHYNNESS_BROWSER=$1 PHYNNESS=$2 PHYNNESS_WRITE_MODELS=$3 PHYNNESS_SOURCE=$4 PHYNNESS_SAMPLE_MODEL=$4/examples/model
build=$5
programs="chromium google-chrome"
[ "$1" = chromium ] || programs="firefox-esr firefox"
# shellcheck disable=SC2086  # several names
PHYNNESS_BROWSER_PROGRAM=$(command -v $programs | head -n 1 || true)
export PHYNNESS_BROWSER_PROGRAM
if [ -z "$PHYNNESS_BROWSER_PROGRAM" ] && [ -z "${CI:-}" ]; then
  echo "skipped: $1 is not installed; tools/install-deps --tests --devices installs it"
  exit 77
fi
cd "$build/work"
screen=()
[ "$1" = chromium ] || screen=(env LIBGL_ALWAYS_SOFTWARE=1 xvfb-run --auto-servernum --server-args '-screen 0 1400x1000x24')
exec "${screen[@]}" node_modules/.bin/vitest run --config browser_tests/vitest.config.ts
