#!/usr/bin/env bash
# Installs the packages of tools/package.sh into a bare Debian 12 that debootstrap makes, tries every
# part of them, and removes them again. Needs root, debootstrap, lintian and the network, so that no
# suite runs it. MIRROR names another mirror, BASE a folder that debootstrap has made before, which is
# copied.
#   tests/packages/bare_debian.sh [FOLDER]      the folder of the packages, out/packages by default
set -Eeuo pipefail
cd "$(dirname "$0")/../.."
source=$PWD
packages=$(realpath "${1:-out/packages}")
mirror=${MIRROR:-http://deb.debian.org/debian}

((EUID == 0)) || { echo "bare_debian.sh: needs root, for debootstrap and chroot" >&2; exit 1; }
for program in debootstrap lintian; do
  command -v $program >/dev/null || { echo "bare_debian.sh: $program is not installed" >&2; exit 1; }
done
compgen -G "$packages/sluice_*.deb" >/dev/null ||
  { echo "bare_debian.sh: no package in $packages; run tools/package.sh first" >&2; exit 1; }

root=$(mktemp -d)
trap 'echo "bare_debian.sh: line $LINENO failed" >&2' ERR
clean_up() {
  mountpoint -q "$root/proc" && umount "$root/proc"
  rm -rf "$root"
}
trap clean_up EXIT
step() { echo "== $*"; }
fail() { echo "bare_debian.sh: $*" >&2; exit 1; }
inside() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"; }
add() { inside apt-get install -y -q --no-install-recommends "$@" >"$root/tmp/apt.log" 2>&1 || { tail -20 "$root/tmp/apt.log"; fail "apt-get install $*"; }; }

step lintian
lintian --fail-on error,warning --tag-display-limit 0 "$packages"/*.deb

step "a bare Debian 12"
if [[ -n ${BASE:-} ]]; then
  cp -a "$BASE/." "$root"
else
  debootstrap --variant=minbase bookworm "$root" "$mirror" >"$root/debootstrap.txt" 2>&1 ||
    { tail -20 "$root/debootstrap.txt"; fail debootstrap; }
fi
mount -t proc proc "$root/proc"
inside apt-get update -q >/dev/null
mkdir "$root/tmp/packages"
cp "$packages"/*.deb "$root/tmp/packages"
in_root() { (cd "$root" && printf '/%s\n' tmp/packages/"$1"_*.deb); }

step "sluice alone"
add "$(in_root sluice)"
unwanted=$(inside dpkg-query -W -f '${Package}\n' | grep -E '^(libgl|libegl|libosmesa|libglfw|libx11|libxcb|libcairo|libopenmpi|libmpich)' || true)
[[ -z $unwanted ]] || fail "the base package brings $unwanted"
inside sluice render -q synth:phantom -o /tmp/p.png
[[ $(head -c 4 "$root/tmp/p.png" | tail -c 3) == PNG ]] || fail "no picture"
inside sluice pack synth:shells,dims=64x64x64 -o /tmp/s.zarr -q
inside sluice info /tmp/s.zarr | grep '64 x 64 x 64 voxels' >/dev/null
for said in "$(inside sluice view synth:phantom 2>&1 || true)" "$(inside sluice render -q synth:phantom -o /tmp/a.png --annotate 2>&1 || true)"; do
  [[ $(wc -l <<<"$said") == 1 && $said == *"; install "* || $said == *" install "* ]] || fail "not one line: $said"
done
add libcairo2 fonts-dejavu-core
inside sluice render -q synth:phantom -o /tmp/a.png --annotate

step "manual pages and completions"
add man-db bash-completion zsh fish
inside man sluice-render | grep -- --threshold >/dev/null
inside mandb --quiet
inside man -k sluice | grep '^sluice-bench-render' >/dev/null
inside bash -c '. /usr/share/bash-completion/bash_completion; _completion_loader sluice || true
  COMP_WORDS=(sluice render --thresh) COMP_CWORD=2; _sluice; [[ ${COMPREPLY[*]} == --threshold ]]'
inside fish -c 'complete -C "sluice render --thresh"' | grep -- --threshold >/dev/null
inside zsh -c 'autoload -U compinit; compinit -D -u; [[ $_comps[sluice] == _sluice ]]'

for name in sluice-window sluice-mpi python3-sluice libsluice0.1 libsluice-dev; do
  step "$name"
  add "$(in_root $name)"
done
inside ldd /usr/lib/x86_64-linux-gnu/sluice/sluice_window.so | grep 'not found' >/dev/null && fail "the window lacks a library"
add openmpi-bin openssh-client
inside mpirun --allow-run-as-root --oversubscribe -n 2 sluice render -q synth:phantom,dims=64x64x64 -o /tmp/two.png
inside python3 -c 'import numpy, sluice
print(sluice.from_array(numpy.arange(4096, dtype="u2").reshape(16, 16, 16)).render(size=32).shape)'

step "find_package and pkg-config"
add g++ make cmake pkg-config
cp -r "$source/examples" "$root/tmp/examples"
inside sh -ec 'cd /tmp/examples; cmake -B build -DCMAKE_BUILD_TYPE=Release >/dev/null; cmake --build build >/dev/null
  build/turntable synth:phantom,dims=64x64x64 20 /tmp/t.png >/dev/null; test -s /tmp/t.png
  g++ -std=c++20 turntable/main.cpp -o by_pkg_config $(pkg-config --cflags --libs sluice)
  ./by_pkg_config synth:phantom,dims=64x64x64 20 /tmp/t2.png >/dev/null; cmp /tmp/t.png /tmp/t2.png'

step "removed"
inside apt-get purge -y -q sluice sluice-window sluice-mpi python3-sluice libsluice0.1 libsluice-dev >/dev/null
left=$(cd "$root" && find . -xdev \( -path ./proc -o -path ./tmp -o -path ./root -o -path ./var/cache/apt -o -path ./var/cache/man -o -path ./var/lib/apt -o -path ./var/log \) -prune -o -iname '*sluice*' -print)
[[ -z $left ]] || fail "left behind: $left"
# The page that was shown above is kept as shown.
inside find /var/cache/man -name 'sluice*' -delete
inside mandb --create --quiet
known=$(inside man -k sluice 2>/dev/null || true)
[[ -z $known ]] || fail "man still knows $known"
step "everything works"
