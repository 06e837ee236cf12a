#!/usr/bin/env bash
# Libraries that are loaded on first use, from outside: where the module is missing, is no module or another version's, a
# tool says so in one line, and does without it where it can.
#   modules.sh BIN
source "$(dirname "${BASH_SOURCE[0]}")/common.sh" "$1"

"$bin/vol-phantom" marschner-lobb --dims 8x8x8 --type u8 -o ml.nrrd || exit 2
"$bin/vol-convert" ml.nrrd -o ml.vdb || exit 2
mkdir -p there/bin there/lib/precis
cp "$bin/vol-info" "$bin/vol-convert" there/bin

names_file() { # COMMAND...: refused, and the line names the file that wanted the module
  refused "$@"
  grep -qE '(ml|new)\.vdb:' err || fail "$*: names no file: $(cat err)"
}

there/bin/vol-info ml.nrrd >/dev/null || fail "vol-info needs the module for NRRD"
names_file there/bin/vol-info ml.vdb
names_file there/bin/vol-convert ml.nrrd -o new.vdb
cp "$bin/../lib/precis/libprecis_oiio.so" there/lib/precis/libprecis_vdb.so 2>/dev/null || fail "no module to borrow"
names_file there/bin/vol-info ml.vdb
echo "no library" >there/lib/precis/libprecis_vdb.so
names_file there/bin/vol-info ml.vdb
[ ! -e new.vdb ] || fail "something was written"

# What lies in the current folder is never loaded.
mkdir -p elsewhere && cp there/lib/precis/libprecis_vdb.so elsewhere/
(cd elsewhere && "$bin/vol-info" ../ml.vdb >/dev/null) || fail "a library was taken from the current folder"
exit $failed
