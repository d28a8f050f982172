#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# With the package libmapjoin-dev installed: includes every header, then builds and runs the user's program in ./consumer, by pkg-config
# and by CMake.
set -e
cd "$(dirname "$0")/consumer"
(cd /usr/include && find mapjoin -name '*.hpp') | sed 's/.*/#include <&>/' >all.cpp
g++ -std=c++20 -fsyntax-only all.cpp $(pkg-config --cflags mapjoin)
g++ -std=c++20 main.cpp -o by-pkg-config $(pkg-config --cflags --libs mapjoin)
./by-pkg-config
cmake -B build
cmake --build build
build/consumer
