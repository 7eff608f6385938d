# Sourced by sh: a bare Debian 12 in the folder $root, which is removed at the end, and in_root COMMAND..., which runs
# there. As root, with debootstrap. MIRROR: where Debian comes from; where it is not set, what apt of this machine uses.

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
for file in /etc/resolv.conf /etc/hosts /etc/pip.conf; do
    [ ! -e "$file" ] || cp "$file" "$root/etc/"
done
# Behind a proxy, whom pip trusts.
cp /etc/ssl/certs/ca-certificates.crt "$root/certificates" 2>/dev/null || true
# The driver for CPUs reads there what processors and memory there are.
mount -t proc proc "$root/proc"
mount -o ro -t sysfs sysfs "$root/sys"

in_root() {
    chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C \
        PIP_CERT="$([ ! -e "$root/certificates" ] || echo /certificates)" DEBIAN_FRONTEND=noninteractive "$@"
}
in_root apt-get update -q
