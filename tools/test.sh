#!/usr/bin/env bash
# Installs what is needed, builds, and runs all tests and gates: the release build, then the fuzzers
# for a bounded time. `tools/test.sh all` adds what takes long: clang-tidy over everything, and the
# sanitizers, which build everything two times more. `tools/test.sh asan` runs one preset.
set -euo pipefail
cd "$(dirname "$0")/.."

tools/setup.sh
presets=("$@")
skip=(-E 'gates\.tidy$')
((${#presets[@]} > 0)) || presets=(release fuzz)
if [[ ${presets[0]} == all ]]; then
  presets=(release fuzz asan tsan)
  skip=()
fi
for preset in "${presets[@]}"; do
  echo "== $preset"
  cmake --preset "$preset" >/dev/null
  cmake --build --preset "$preset"
  ctest --preset "$preset" -j "$(nproc)" --output-on-failure "${skip[@]}"
done
