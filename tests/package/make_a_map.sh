#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# A new user's first steps with the package mapjoin installed: a log, its map, and a page that shows it.
set -e
cd /usr/share/doc/mapjoin
mapjoin run data/manhattan2d.g2o -o /root/map
mapjoin plot /root/map -o /root/map.html
test -s /root/map/report.json -a -s /root/map.html
