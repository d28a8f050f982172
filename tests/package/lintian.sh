#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# lintian.sh FOLDER: Debian's checker has no errors and no warnings for the packages in the folder.
set -euo pipefail
command -v lintian >/dev/null || { echo "lintian is not installed"; exit 77; }
# Nobody asked Debian for these packages; and there is one folder for libraries, not one for each machine.
lintian --allow-root --fail-on error,warning \
  --suppress-tags initial-upload-closes-no-bugs,pkg-config-unavailable-for-cross-compilation "$1"/*.deb
