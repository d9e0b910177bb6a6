#!/usr/bin/env bash
# Builds the documents as pages with search into out/docs; open out/docs/index.html. Needs Debian's
# mkdocs, and doxygen for the pages of the library's headers. Options go to `mkdocs build`.
set -euo pipefail
cd "$(dirname "$0")/.."
command -v mkdocs >/dev/null || { echo "docs.sh: mkdocs is not installed (apt-get install mkdocs)" >&2; exit 1; }
mkdocs --quiet build --strict -f tools/docs/mkdocs.yml "$@"
