#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# fresh_debian.sh PACKAGES INCLUDE SCRIPT [FOLDER]: runs the script in a Debian 12 that has nothing but what INCLUDE (names of packages,
# between commas) asks for, ours from the folder PACKAGES. mmdebstrap makes that system and throws it away; where it cannot (no network,
# no rights) the test says so and is skipped.
set -euo pipefail
unset CMAKE_CXX_COMPILER_LAUNCHER # that of this machine
packages=$(realpath "$1") include=$2 script=$(realpath "$3")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# An archive of its own, so that apt finds what the packages depend on. dpkg unpacks within the new system: hence copy:, not file:.
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
