#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# pkg_config.sh FOLDER_OF_PC COMPILER MAIN_CPP PROGRAM: compiles a user's program with the flags of pkg-config, and runs it.
set -euo pipefail
export PKG_CONFIG_PATH=$1
# Word splitting is intended: one flag per word.
"$2" -std=c++20 "$3" -o "$4" $(pkg-config --cflags --libs mapjoin)
"$4"
