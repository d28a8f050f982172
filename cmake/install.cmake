# SPDX-License-Identifier: BSD-3-Clause
# What is installed: libraries, headers, the command, and the CMake package.
