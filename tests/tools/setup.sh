#!/usr/bin/env bash
# pipelines/setup without the right to install: it prints the one line to run and ends with 2; with nothing missing it
# says nothing. Stand-ins for dpkg-query, apt-get, id and sudo play the machine.
#   setup.sh SOURCE_FOLDER
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail() { echo "$*"; exit 1; }

stand_in() { printf '#!/bin/sh\n%s\n' "$2" >"$folder/$1"; chmod +x "$folder/$1"; }
stand_in apt-get "echo called >>'$folder/apt-called'"
stand_in id 'echo 1000'
stand_in sudo 'exit 1'

stand_in dpkg-query 'shift 2; for p in "$@"; do [ "$p" = libtbb-dev ] || echo "$p installed"; done'
status=0
said=$(PATH="$folder:$PATH" "$1/pipelines/setup" build 2>/dev/null </dev/null) || status=$?
[ "$status" = 2 ] || fail "without root: status $status, not 2"
[ "$said" = "apt-get update && apt-get install -y --no-install-recommends libtbb-dev" ] || fail "printed: $said"
[ ! -e "$folder/apt-called" ] || fail "apt-get was called without root"

stand_in dpkg-query 'shift 2; for p in "$@"; do echo "$p installed"; done'
said=$(PATH="$folder:$PATH" "$1/pipelines/setup" 2>&1) || fail "with all there: status $?"
[ -z "$said" ] || fail "with all there it said: $said"
[ ! -e "$folder/apt-called" ] || fail "apt-get was called with nothing missing"

status=0
"$1/pipelines/setup" no-such-set 2>/dev/null || status=$?
[ "$status" = 2 ] || fail "an unknown set: status $status, not 2"
