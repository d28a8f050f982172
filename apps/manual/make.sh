#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# make.sh MAPJOIN FOLDER: writes man pages (man1/, by help2man) and a page of Markdown per command (commands/), from --help.
set -euo pipefail
export PATH="$(dirname "$1"):$PATH"
man=$2/man1 pages=$2/commands
mkdir -p "$man" "$pages"

mapfile -t commands < <(mapjoin --help | sed -nE '/^Commands:/,/^$/s/^  ([a-z]+)  .*/\1/p')
description_of() { mapjoin --help | sed -nE "s/^  $1  +(.*)/\1/p"; }

ends=$(mktemp)
trap 'rm -f "$ends"' EXIT
{
  printf '[EXIT STATUS]\n%s\n\n' "$(mapjoin --help | sed -n '/^Exit codes:/,$p')"
  printf '[SEE ALSO]\n.BR mapjoin (1)\n'
  printf '.BR mapjoin-%s (1)\n' "${commands[@]}"
} >"$ends"
# man_page NAME DESCRIPTION COMMAND: from the help of COMMAND; each example keeps its line.
man_page() {
  help2man --no-info --include="$ends" --name="$2" --version-string="$(mapjoin --version)" "$3" |
    sed -e "s/^\.TH MAPJOIN /.TH ${1^^} /; s/^mapjoin \\\\-/$1 \\\\-/" \
      -e '/^\.SH EXAMPLES/,/^\.SH "SEE/s/^mapjoin .*/&\n.br/' >"$man/$1.1"
}

man_page mapjoin 'large maps from many small ones by submap joining' mapjoin
printf '# Commands\n\nEach page is what `--help` prints.\n\n| command | what it does |\n|---|---|\n' >"$pages/README.md"
for command in "${commands[@]}"; do
  description=$(description_of "$command")
  man_page "mapjoin-$command" "$description" "mapjoin $command"
  printf '| [`mapjoin %s`](%s.md) | %s |\n' "$command" "$command" "$description" >>"$pages/README.md"
  {
    printf '# mapjoin %s\n\n%s.\n\n```console\n$ mapjoin %s --help\n' "$command" "$description" "$command"
    mapjoin "$command" --help
    printf '```\n\n[The other commands](README.md)\n'
  } >"$pages/$command.md"
done
