#!/bin/bash
# Claim: the runtime builds from its own folder, installs, and an external C program finds and uses it.
# Usage: builds_alone_and_installs.sh CMAKE RUNTIME_SOURCE CONSUMER_SOURCE WORK_DIR
set -euo pipefail
cmake=$1
runtime=$2
consumer=$3
work=$4
command -v make > /dev/null || export CMAKE_GENERATOR=Ninja
rm -rf "$work"
"$cmake" -S "$runtime" -B "$work/runtime" -DCMAKE_INSTALL_PREFIX="$work/prefix" > "$work.log"
"$cmake" --build "$work/runtime" >> "$work.log"
"$cmake" --install "$work/runtime" >> "$work.log"
"$cmake" -S "$consumer" -B "$work/consumer" -DCMAKE_PREFIX_PATH="$work/prefix" >> "$work.log"
"$cmake" --build "$work/consumer" >> "$work.log"
"$work/consumer/c_consumer"
