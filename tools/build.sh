#!/usr/bin/env bash
# Configures (once) and builds the package in build/; incremental, quick when nothing changed.
cd "$(dirname "$0")/.." || exit 1
# shellcheck source=tools/steps.sh
source tools/steps.sh
# shellcheck source=tools/env.sh
source tools/env.sh

python="$PWD/.venv/bin/python3"
if [ ! -f build/Makefile ] || [ CMakeLists.txt -nt build/Makefile ]; then
  step configure cmake -S . -B build -DCMAKE_BUILD_TYPE=Release \
    -DPYTHON_EXECUTABLE="$python" -DPython3_EXECUTABLE="$python" -DCATKIN_DEVEL_PREFIX="$PWD/devel"
fi
step build make -C build -j"$(nproc)" all
if [ "${1:-}" = tests ]; then
  step build-tests make -C build -j"$(nproc)" tests
fi
