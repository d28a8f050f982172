#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# unpacked.sh PACKAGES: the packages, unpacked into an empty folder, are complete; the command there makes a map.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

for package in "$1"/*.deb; do dpkg-deb --extract "$package" "$folder"; done
cd "$folder/usr"
bin/mapjoin run share/doc/mapjoin/data/manhattan2d.g2o -o map
for file in map/report.json share/man/man1/mapjoin{,-run}.1.gz share/bash-completion/completions/mapjoin \
  share/zsh/vendor-completions/_mapjoin \
  include/mapjoin/join/run.hpp include/mapjoin/version.hpp lib/libmapjoin_{core,localmap,join}.a \
  lib/cmake/mapjoin/mapjoin-config.cmake lib/pkgconfig/mapjoin.pc share/doc/{mapjoin,libmapjoin-dev}/copyright; do
  test -s "$file" || { echo "$file is missing"; exit 1; }
done
