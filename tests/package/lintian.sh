#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# lintian.sh FOLDER: Debian's checker has no errors and no warnings for the packages in the folder.
set -euo pipefail
command -v lintian >/dev/null || { echo "lintian is not installed"; exit 77; }
# Suppressed: a bug by which Debian was asked for the packages, and a folder of libraries for each architecture.
lintian --allow-root --fail-on error,warning \
  --suppress-tags initial-upload-closes-no-bugs,pkg-config-unavailable-for-cross-compilation "$1"/*.deb
