#!/usr/bin/env bash
# Installs what is needed, builds, and runs all tests: the release build with the gates, then the
# sanitizers, then the fuzzers for a bounded time. Some of it: tools/test.sh release asan
# `quick` is the release build without the slow clang-tidy gate.
set -euo pipefail
cd "$(dirname "$0")/.."

tools/setup.sh
presets=("$@")
((${#presets[@]} > 0)) || presets=(release asan tsan fuzz)
for preset in "${presets[@]}"; do
  echo "== $preset"
  skip=()
  if [[ $preset == quick ]]; then
    preset=release
    skip=(-E 'gates\.tidy$')
  fi
  cmake --preset "$preset" >/dev/null
  cmake --build --preset "$preset"
  ctest --preset "$preset" -j "$(nproc)" --output-on-failure "${skip[@]}"
done
