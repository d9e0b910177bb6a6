#!/usr/bin/env bash
# Every source is as clang-format writes it. Mend with: tests/gates/check_format.sh --fix
set -euo pipefail
cd "$(dirname "$0")/../.."

# Versions differ in their taste; Debian 12's is the measure.
if ! clang-format --version 2>/dev/null | grep -q 'version 14\.'; then
  echo "clang-format 14 is not installed (tools/setup.sh installs it)"
  exit 77
fi
mode=(--dry-run --Werror)
[ "${1:-}" = --fix ] && mode=(-i)
find include src io cache tools python tests examples \( -name '*.h' -o -name '*.cpp' \) -print0 |
  xargs -0 -n 20 -P 2 clang-format "${mode[@]}"
