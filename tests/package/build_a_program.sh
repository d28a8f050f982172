#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# A user's program in ./consumer, with the package libmapjoin-dev installed: by pkg-config, then by CMake. Every header can be included.
set -e
cd "$(dirname "$0")/consumer"
(cd /usr/include && find mapjoin -name '*.hpp') | sed 's/.*/#include <&>/' >all.cpp
g++ -std=c++20 -fsyntax-only all.cpp $(pkg-config --cflags mapjoin)
g++ -std=c++20 main.cpp -o by-pkg-config $(pkg-config --cflags --libs mapjoin)
./by-pkg-config
cmake -B build
cmake --build build
build/consumer
