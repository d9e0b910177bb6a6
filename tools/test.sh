#!/usr/bin/env bash
# Installs what is needed, builds, and runs what must pass before a change lands: all tests and gates
# of an optimized build whose sources are compiled in batches and in which a warning is an error,
# clang-tidy over the sources that changed since it found nothing, the fuzzers for a bounded time, and
# under sanitizers what threads share: levels 2 to 4, the frame and the CPU device (asan-fast,
# tsan-fast).
# `tools/test.sh all` adds what takes long: clang-tidy over everything, and the sanitizers over the
# rest of it. `tools/test.sh asan` runs one preset. At the end: what each part took of the processor.
set -euo pipefail
cd "$(dirname "$0")/.."

tools/setup.sh
presets=("$@")
# Of batches alone: what is left out on the command line takes the place of what a preset leaves out.
skip=(-E 'gates\.tidy_all$')
((${#presets[@]} > 0)) || presets=(batches fuzz asan-fast tsan-fast)
if [[ ${presets[0]} == all ]]; then
  presets=(batches fuzz asan-fast tsan-fast asan tsan)
  skip=()
fi

# Into `now`: seconds of processor that this script's children took so far. A subshell would not know.
scratch=$(mktemp)
trap 'rm -f "$scratch"' EXIT
note_processor() {
  times >"$scratch"
  now=$(awk 'END { split($0, part, /[ms ]+/); print part[1] * 60 + part[2] + part[3] * 60 + part[4] }' "$scratch")
}

table=()
for preset in "${presets[@]}"; do
  echo "== $preset"
  note_processor
  before=$now
  without=()
  [[ $preset != batches ]] || without=("${skip[@]}")
  cmake --preset "$preset" >/dev/null
  cmake --build --preset "$preset"
  note_processor
  built=$now
  # One more than there are processors: many tests wait for a server, a disk or a signal.
  ctest --preset "$preset" -j "$(($(nproc) + 1))" --output-on-failure "${without[@]}"
  note_processor
  table+=("$(awk -v p="$preset" -v a="$before" -v b="$built" -v c="$now" \
    'BEGIN { printf "%-10s %6.0f s to build, %6.0f s to test", p, b - a, c - b }')")
done
echo "== of the processor"
printf '%s\n' "${table[@]}"
