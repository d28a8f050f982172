#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# A map by two processes, with the packages mapjoin and mapjoin-mpi installed.
set -eu
mpirun --allow-run-as-root --oversubscribe -n 2 mapjoin-mpi run /usr/share/doc/mapjoin/data/manhattan2d.g2o -o /tmp/map.g2o
test -s /tmp/map.g2o
