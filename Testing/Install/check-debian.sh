#!/bin/sh
# The README's commands in a fresh Debian of its own, which nothing outside can reach into: an hour or more, 8 GB.
#
# check-debian.sh RELEASE FOLDER [MAKE-ARGUMENT...]
#
# RELEASE is bookworm, trixie or sid. FOLDER/RELEASE is made, or found: then packages and build of the last time are used
# again, but for what has changed since. As root, with the package debootstrap. The arguments go to `make demo` and `make
# check`; with PARAVIEW=OFF, where nothing can be demonstrated, to the latter alone. Environment: MIRROR, APT_CONF: a file
# for /etc/apt/apt.conf.d (proxies, old snapshots).
set -eu

release=$1
root=$2/$release
shift 2
mirror=${MIRROR:-http://deb.debian.org/debian}
source=$(cd "$(dirname "$0")/../.." && pwd)

mkdir -p "$root"
if [ ! -e "$root/etc/os-release" ]; then
  debootstrap --variant=minbase --include=ca-certificates,make "$release" "$root" "$mirror"
fi
if [ -n "${APT_CONF:-}" ]; then
  cp "$APT_CONF" "$root/etc/apt/apt.conf.d/90check-debian"
fi
mkdir -p "$root/treeamr" "$root/etc/dpkg/dpkg.cfg.d"
echo force-unsafe-io > "$root/etc/dpkg/dpkg.cfg.d/check-debian"
find "$root/treeamr" -mindepth 1 -maxdepth 1 ! -name build -exec rm -r {} +
git -C "$source" ls-files -z --cached --others --exclude-standard |
  tar -C "$source" --null --files-from=- --ignore-failed-read -c | tar -C "$root/treeamr" -x

goals="demo check"
for argument; do
  if [ "$argument" = PARAVIEW=OFF ]; then
    goals=check
  fi
done
# Mounts and processes end with the command.
exec unshare --mount --pid --fork --kill-child sh -c '
  root=$1
  shift
  mount -t proc proc "$root/proc"
  mount --rbind /dev "$root/dev"
  mount --rbind /sys "$root/sys"
  exec chroot "$root" env -i HOME=/root LANG=C.UTF-8 PATH=/usr/sbin:/usr/bin:/sbin:/bin make -C /treeamr "$@"' \
  - "$root" $goals "$@"
