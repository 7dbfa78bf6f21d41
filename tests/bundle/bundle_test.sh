#!/usr/bin/env bash
# The bundle in a bare Debian (debootstrap --variant=minbase) with lavapipe's driver put beside it: list, encode, draw, rehearse.
# $1: the source tree. Needs root and debootstrap; exit code 77 (skipped) says that one is missing.
set -euo pipefail
source=$1
[[ $(id -u) == 0 ]] || { echo "skipped: not root"; exit 77; }
command -v debootstrap >/dev/null || { echo "skipped: no debootstrap"; exit 77; }
work=$(mktemp -d)
trap 'umount "$work/root/proc" 2>/dev/null || true; rm -rf "$work"' EXIT

tarball=$("$source/scripts/bundle" --into "$work/bundle" | tail -1)
bytes=$(stat -c %s "$tarball")
((bytes < 60 * 1024 * 1024)) || { echo "FAILED: $bytes bytes, expected less than 60 MiB"; exit 1; }
debootstrap --variant=minbase bookworm "$work/root" >"$work/log" 2>&1 || { cat "$work/log"; echo "skipped: debootstrap found no packages"; exit 77; }
mount -t proc proc "$work/root/proc"
tar -C "$work/root/opt" -xJf "$tarball"
mv "$work"/root/opt/cvrbench-* "$work/root/opt/cvrbench"

# The machine's driver: lavapipe with its own libraries, in a folder of its own.
driver=$(find /usr/share/vulkan/icd.d -name 'lvp_icd*.json' -print -quit)
library=$(ldconfig -p | awk '/libvulkan_lvp\.so/ && !n++ {print $NF}')
[[ -n $library ]] || library=$(find /usr/lib -name 'libvulkan_lvp.so' -print -quit)
mkdir -p "$work/root/opt/driver"
cp -L "$library" "$work/root/opt/driver/"
ldd "$library" | awk '$3 ~ /^\// {print $3}' | grep -v -E '/(libc|libm|libpthread|libdl|librt)\.so' | xargs -I{} cp -L {} "$work/root/opt/driver/"
sed -E 's#"library_path": *"[^"]*"#"library_path": "/opt/driver/libvulkan_lvp.so"#' "$driver" >"$work/root/opt/driver/lvp.json"
cp "$source/tests/bundle/rehearsal.yaml" "$work/root/opt/"

chroot "$work/root" /usr/bin/env -i PATH=/usr/bin:/bin HOME=/root VK_DRIVER_FILES=/opt/driver/lvp.json LD_LIBRARY_PATH=/opt/driver bash -euo pipefail -c '
  cd /tmp
  /opt/cvrbench/bin/cvrbench --version
  /opt/cvrbench/bin/cvrbench list devices | grep llvmpipe >/dev/null
  /opt/cvrbench/bin/cvrbench generate cells --size 40,40,40 --seed 1 -o a.h5
  /opt/cvrbench/bin/cvrbench encode a.h5 --codec csgvr-sb -o a.cvr
  /opt/cvrbench/bin/cvrbench error a.h5 a.cvr
  /opt/cvrbench/bin/cvrbench render a.cvr --scene cells --size 64x36 -o a.png
  test -s a.png
  /opt/cvrbench/gpu-run out --budget 3000 --device software --config /opt/rehearsal.yaml --skip-tests
  grep -q "| cells " out/summary.md
  grep -q /opt/driver/lvp.json out/device.txt
'
echo "passed: $bytes bytes packed"
