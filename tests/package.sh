#!/bin/sh
# Whether the Debian package installs and runs in a bare Debian 12:
#   sh setup.sh package && sh tests/package.sh [PACKAGE.deb]
# As root, with debootstrap. MIRROR: where Debian comes from; where it is not set, what apt of this machine uses.
# The system is a folder in $TMPDIR, which is removed.
set -eu
cd "$(dirname "$0")/.."
package=${1:-$(ls -t build-package/brdfit_*.deb 2>/dev/null | head -n 1)}
if [ ! -f "$package" ]; then
    echo "no package ${package:-in build-package}; sh setup.sh package makes one" >&2
    exit 2
fi

# The first mirror in apt's sources that is no security archive.
mirror=${MIRROR:-$(cat /etc/apt/sources.list /etc/apt/sources.list.d/* 2>/dev/null |
    sed -n -e 's/^URIs: *\([^ ]*\).*/\1/p' -e 's/^deb \(\[[^]]*\] \)\{0,1\}\([^ ]*\).*/\2/p' |
    grep -v security | head -n 1)}
mirror=${mirror:-http://deb.debian.org/debian}

folder=$(mktemp -d)
trap 'for f in proc sys; do umount "$folder/root/$f" 2>/dev/null || true; done
    rm -rf --one-file-system "$folder"' EXIT
trap 'exit 1' HUP INT TERM
root=$folder/root
debootstrap --variant=minbase bookworm "$root" "$mirror"
cat /etc/apt/apt.conf.d/*proxy* >"$root/etc/apt/apt.conf.d/proxy" 2>/dev/null || true
cp /etc/resolv.conf /etc/hosts "$root/etc/"
cp "$package" "$root/brdfit.deb"
# The driver for CPUs reads there what processors and memory there are.
mount -t proc proc "$root/proc"
mount -o ro -t sysfs sysfs "$root/sys"

in_root() {
    chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C \
        DEBIAN_FRONTEND=noninteractive "$@"
}
in_root apt-get update -q
in_root apt-get install -q -y --install-recommends /brdfit.deb
in_root brdfit devices
in_root brdfit demo -o /demo
[ -s "$root/demo/summary.csv" ]
[ -s "$root/usr/share/man/man1/brdfit-fit.1" ]
in_root bash -c '. /usr/share/bash-completion/completions/brdfit
    COMP_WORDS=(brdfit sta) COMP_CWORD=1
    _brdfit
    [ "${COMPREPLY[*]}" = status ]'
echo "$package installs and runs in a bare Debian 12"
