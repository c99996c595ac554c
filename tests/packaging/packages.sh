#!/usr/bin/env bash
# packages.sh BUILD ROOT VIEWER_TEST: builds the Debian packages, looks at them, and, where that is
# possible, installs them in a clean Debian 12 root and runs them there; VIEWER_TEST, which presses
# keys in the viewer's window, runs from here with the program of that root. Exit code 77: not
# possible here.
set -euo pipefail
build=$1 root=$2 viewer_test=$3
work=$(mktemp -d)
clean() {
  mountpoint -q "$work/debian/proc" && umount "$work/debian/proc"
  rm -rf --one-file-system "$work"
}
trap clean EXIT
fail() { echo "packages: $*" >&2; exit 1; }

(cd "$build" && cpack -G DEB -B "$work/packages" > "$work/cpack.log" 2>&1) || {
  cat "$work/cpack.log"; fail "cpack failed"; }
ls -l "$work"/packages/*.deb
has() { dpkg-deb -c "$work"/packages/"$1"_*.deb | grep "$2" > /dev/null || fail "$1 lacks $2"; }
lacks() { ! dpkg-deb -c "$work"/packages/"$1"_*.deb | grep "$2" > /dev/null || fail "$1 has $2"; }
needs() { dpkg-deb -f "$work"/packages/"$1"_*.deb Depends | grep "$2" > /dev/null || fail "$1 does not depend on $2"; }
free_of() { ! dpkg-deb -f "$work"/packages/"$1"_*.deb Depends | grep -E "$2" > /dev/null || fail "$1 depends on $2"; }
has arbox-geometry usr/include/arbox/geometry/box.h
has arbox-geometry usr/lib/libarbox_geometry.so
lacks arbox-geometry libarbox_io
free_of arbox-geometry 'torch|opencv|pcl|vtk'
has arbox-io usr/lib/libarbox_io.so
needs arbox-io arbox-geometry
free_of arbox-io 'torch|opencv|vtk'
has arbox usr/bin/arbox
has arbox usr/lib/arbox/libarbox_program_torch.so
has arbox usr/share/arbox/example_head
has arbox usr/share/arbox/examples/street.bin
has arbox usr/share/arbox/models/pv_rcnn_compact.arbox
needs arbox arbox-io
needs arbox torch
free_of arbox 'vtk|cgal'
has arbox-viewer usr/lib/arbox/libarbox_program_viewer.so
needs arbox-viewer vtk

if [ "$(id -u)" -ne 0 ] || ! command -v debootstrap > /dev/null; then
  echo "packages: built and right; not installed: needs root and the package debootstrap"
  exit 77
fi
mirror=${ARBOX_DEBIAN_MIRROR:-http://deb.debian.org/debian}
if ! debootstrap --variant=minbase bookworm "$work/debian" "$mirror" > "$work/debootstrap.log" 2>&1; then
  tail -n 3 "$work/debootstrap.log"
  echo "packages: built and right; not installed: debootstrap cannot make a root from $mirror"
  exit 77
fi
cp "$work"/packages/*.deb "$work/debian/root/"
cp "$root/examples/data/street.bin" "$work/debian/root/"
inside() { chroot "$work/debian" env DEBIAN_FRONTEND=noninteractive LC_ALL=C "$@"; }
mount -t proc proc "$work/debian/proc"
printf '#!/bin/sh\nexit 101\n' > "$work/debian/usr/sbin/policy-rc.d"
chmod +x "$work/debian/usr/sbin/policy-rc.d"
# The root is thrown away: no need to wait for the disk.
echo force-unsafe-io > "$work/debian/etc/dpkg/dpkg.cfg.d/unsafe-io"
install() {
  inside sh -c "apt-get install -y -qq --no-install-recommends $* > /tmp/log 2>&1 || { tail -n 5 /tmp/log; exit 1; }"
}
install /root/arbox-geometry_*.deb || fail "arbox-geometry does not install"
install /root/arbox-io_*.deb || fail "arbox-io does not install"
install /root/arbox_*.deb || fail "arbox does not install"
inside arbox detect /root/street.bin --detector cluster_fit --quantile 0.2 --format csv | grep Car > /dev/null || fail "no car found"
inside arbox config show head/autoregressive | grep hidden > /dev/null || fail "LibTorch's part does not open"
inside arbox view --cloud /root/street.bin --html /root/page.html
# refused CODE TEXT [NAME=VALUE]: the viewer ends with CODE and says TEXT.
refused() {
  local code=0
  inside env -u DISPLAY "${@:3}" arbox view --cloud /root/street.bin --interactive > "$work/said" 2>&1 || code=$?
  [ "$code" -eq "$1" ] && grep -F "$2" "$work/said" > /dev/null || {
    cat "$work/said"; fail "the viewer ended with $code, expected $1 and '$2'"; }
}
refused 2 'DISPLAY is not set'
refused 1 'install the package arbox-viewer' DISPLAY=:4242
install /root/arbox-viewer_*.deb || fail "arbox-viewer does not install"
refused 2 'DISPLAY is not set'
refused 2 "':4242' cannot be opened" DISPLAY=:4242
# The program of the root under the name of a program of ours; both see the files that the test
# writes under the same names.
printf '#!/bin/sh\nexec chroot "%s" arbox "$@"\n' "$work/debian" > "$work/arbox"
chmod +x "$work/arbox"
mkdir -p "$work/debian$work/shared" "$work/debian$root/examples/data"
ln -s "$work/debian$work/shared" "$work/shared"
cp "$root/examples/data/street.bin" "$work/debian$root/examples/data/"
TMPDIR="$work/shared" ARBOX_PROGRAM="$work/arbox" "$viewer_test" || fail "the viewer does not work"

# What docs/plugin-author.md asks for is enough to build a plugin.
needed=$(sed -n 's/^ *sudo apt install \(g++ .*\)/\1/p' "$root/docs/plugin-author.md")
install "${needed:-no-such-package}" || fail "what plugins need does not install: $needed"
inside sh -c '(cmake -S /usr/share/arbox/example_head -B /root/head && cmake --build /root/head) > /tmp/log 2>&1 ||
  { tail -n 20 /tmp/log; exit 1; }' || fail "the example head does not build"
inside arbox plugins check /root/head/libarbox_head_linear_gaussian.so | grep 'fits this build' > /dev/null ||
  fail "the example head does not fit"
echo "packages: installed and run in a clean Debian 12"
