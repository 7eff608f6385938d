#!/bin/sh
# Whether the Debian package installs and runs in a bare Debian 12:
#   sh setup.sh package && sh tests/package.sh [PACKAGE.deb]
# As root, with debootstrap; see bare_debian.sh.
set -eu
cd "$(dirname "$0")/.."
package=${1:-$(ls -t build-package/brdfit_*.deb 2>/dev/null | head -n 1)}
if [ ! -f "$package" ]; then
    echo "no package ${package:-in build-package}; sh setup.sh package makes one" >&2
    exit 2
fi

. tests/bare_debian.sh
cp "$package" "$root/brdfit.deb"
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
