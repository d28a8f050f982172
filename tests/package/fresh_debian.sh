#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# fresh_debian.sh PACKAGES INCLUDE SCRIPT [FOLDER]: runs the script, with a copy of FOLDER beside it, in a minimal Debian 12 with the
# packages INCLUDE (names between commas), ours from the folder PACKAGES. mmdebstrap makes that system and throws it away; if it cannot
# (no network, no rights) the test says so and is skipped.
set -euo pipefail
unset CMAKE_CXX_COMPILER_LAUNCHER # absent from the new system
packages=$(realpath "$1") include=$2 script=$(realpath "$3")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# An archive of our packages, so that apt installs what they depend on; copy:, not file:, since dpkg unpacks within the new system.
cp "$packages"/*.deb "$folder"
(cd "$folder" && dpkg-scanpackages --multiversion . >Packages)
mirrors=("deb http://deb.debian.org/debian bookworm main" "deb http://deb.debian.org/debian bookworm-updates main"
  "deb http://deb.debian.org/debian-security bookworm-security main" "deb [trusted=yes] copy:$folder ./")

debian() {
  mmdebstrap --quiet --variant=minbase --format=null --dpkgopt=force-unsafe-io --include="$include" "$@" bookworm /dev/null "${mirrors[@]}"
}

if ! debian --simulate >"$folder/simulated" 2>&1; then
  cat "$folder/simulated"
  echo "SKIPPED: no fresh Debian can be made here (see above)."
  exit 77
fi
debian --customize-hook="copy-in $script ${4:+$(realpath "$4")} /root" --customize-hook="chroot \"\$1\" sh /root/$(basename "$script")"
