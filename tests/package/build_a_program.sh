#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# A user's program in ./consumer, with the package libmapjoin-dev installed: by pkg-config, then by CMake.
set -e
cd "$(dirname "$0")/consumer"
g++ -std=c++20 main.cpp -o by-pkg-config $(pkg-config --cflags --libs mapjoin)
./by-pkg-config
cmake -B build
cmake --build build
build/consumer
