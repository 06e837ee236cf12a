#!/bin/sh
# Every man page and completion that the build made is well-formed: groff reads it without a warning, bash parses it.
#   man_pages.sh BUILD/docs
set -eu
bad=0
count=0
for page in "$1"/man/*.1; do
  count=$((count + 1))
  said=$(groff -man -Tutf8 -ww -z "$page" 2>&1) || bad=1
  [ -z "$said" ] || { echo "$said"; bad=1; }
  text=$(groff -man -Tutf8 "$page" | sed 's/\x1b\[[0-9;]*m//g; s/.\x08//g')
  for section in NAME SYNOPSIS DESCRIPTION EXAMPLE; do
    printf '%s\n' "$text" | grep -q "^ *$section" || { echo "$page: no section $section"; bad=1; }
  done
done
[ "$count" -gt 0 ] || { echo "no man page in $1/man"; exit 1; }
for script in "$1"/bash/*; do
  bash -n "$script" || bad=1
done
exit $bad
