# Sourced by the tests of the tools from outside: the tools' folder in $bin, a folder of its own to work in, which goes at
# the end, and fail, which says why and lets the test go on.
set -u
bin=$(realpath "$1")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 2
failed=0

fail() {
  echo "$*"
  failed=1
}
refused() { # COMMAND...: status 2 and one line, kept in err
  "$@" >/dev/null 2>err
  local status=$?
  [ $status -eq 2 ] || fail "status $status, not 2: $*"
  [ "$(wc -l <err)" -eq 1 ] || fail "one line expected of: $*: $(cat err)"
}
refused_for() { # WORD COMMAND...: refused, and the line has the word
  local word=$1
  shift
  refused "$@"
  grep -qF -- "$word" err || fail "no word of '$word': $*: $(cat err)"
}
