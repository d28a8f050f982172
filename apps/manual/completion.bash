# SPDX-License-Identifier: BSD-3-Clause
# bash completion of mapjoin: it asks the command's own --help.

# The options of a command, one a line: its names, and the kind of its value where it takes one.
_mapjoin_options() {
  "$@" --help 2>/dev/null | sed -nE 's/^  ((-[a-z], )?--?[a-z0-9-]+( [^ ]+)?)( REQUIRED)?(  .*|$)/\1/p'
}

_mapjoin() {
  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} words= kind= options
  COMPREPLY=()
  if ((COMP_CWORD == 1)); then
    words=$("${COMP_WORDS[0]}" --help | sed -nE '/^Commands:/,/^$/s/^  ([a-z]+)  .*/\1/p')
    COMPREPLY=($(compgen -W "$words --help --version" -- "$current"))
    return
  fi
  options=$(_mapjoin_options "${COMP_WORDS[@]:0:2}")
  if [[ $previous == -* ]]; then
    kind=$(sed -nE "s/^(.*, )?$previous(, .*)? ([^ -][^ ]*)\$/\3/p" <<<"$options")
  fi
  case $kind in
    DIR) compopt -o dirnames ;;
    *FILE* | *MAP* | *LOG*) compopt -o default ;;
    '') if [[ $current == -* ]]; then words=$(grep -oE -e '--?[a-z][a-z0-9-]*' <<<"$options"); else compopt -o default; fi ;;
    *) words=$(grep -oE '[a-z][a-z0-9-]*' <<<"${kind//|/ }") ;;
  esac
  COMPREPLY=($(compgen -W "$words" -- "$current"))
}
complete -F _mapjoin mapjoin
