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
