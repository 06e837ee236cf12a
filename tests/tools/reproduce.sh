#!/usr/bin/env bash
# pipelines/reproduce by itself: which sweeps each form runs and how, and what its status says. Stand-ins play the set-up, the
# build, the page and Snakemake, which here hands back the committed tables.
#   reproduce.sh SOURCE_FOLDER
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail() { echo "$*"; cat "$folder/said" "$folder/calls" 2>/dev/null; exit 1; }

mkdir "$folder/pipelines" "$folder/bin"
cp "$1"/pipelines/{reproduce,sweeps.txt,check.py,records.py,sweep.py} "$1"/pipelines/*.yaml "$folder/pipelines"
for table in "$1"/results/*/table.csv; do
  name=$(basename "$(dirname "$table")")
  mkdir -p "$folder/results/$name"
  cp "$table" "$folder/results/$name"
done
stand_in() { printf '#!/usr/bin/env bash\n%s\n' "$2" >"$folder/$1"; chmod +x "$folder/$1"; }
stand_in pipelines/setup 'echo "setup $*" >>calls'
stand_in pipelines/build 'echo "build $*" >>calls'
printf 'import sys\nopen("calls", "a").write("report " + " ".join(sys.argv[1:]) + "\\n")\n' >"$folder/pipelines/report.py"
stand_in bin/snakemake '
configured="" options=""
while [ $# -gt 0 ]; do
  case $1 in
    --configfile) configured=$2; shift ;;
    *=true) options="$options $1" ;;
  esac
  shift
done
name=$(basename "$configured" .yaml)
echo "$name$options" >>calls
[ "$name" != "${BROKEN-}" ] || { echo "no such rule"; exit 1; }
case $options in *short_form*) to=out/$name-short${PRECIS_SIMD:+-$PRECIS_SIMD}/results ;; *) to=results/$name ;; esac
mkdir -p "$to"
[ ! -e "results/$name/table.csv" ] || [ "$to" = "results/$name" ] || cp "results/$name/table.csv" "$to"
[ "$name" != "${MOVED-}" ] || sed -i "2s/,kept$/,NOT KEPT/" "$to/table.csv"'
sed -i "s|/usr/bin/snakemake|$folder/bin/snakemake|" "$folder/pipelines/reproduce"

all=$(awk '/^[a-z]/ {print $1}' "$1/pipelines/sweeps.txt")
checked=$(awk '$2 == "check" {print $1}' "$1/pipelines/sweeps.txt")
# reproduce STATUS ARGUMENT...: what it ran is in `ran`.
reproduce() {
  local wanted=$1 status=0
  shift
  rm -rf "$folder/calls" "$folder/out"
  "$folder/pipelines/reproduce" "$@" >"$folder/said" 2>&1 || status=$?
  [ "$status" = "$wanted" ] || fail "reproduce $*: status $status, not $wanted"
  ran=$(grep -vE '^(setup|build|report) ' "$folder/calls" 2>/dev/null || true)
}
expect() { [ "$ran" = "$1" ] || fail "ran: $ran; expected: $1"; }

reproduce 0
expect "$(sed 's/$/ short_form=true/' <<<"$all")"
grep -qx 'setup build pipelines' "$folder/calls" || fail "not set up"
grep -qx 'build release sweeps' "$folder/calls" || fail "not built"
grep -qx 'report --short -o out/report.html' "$folder/calls" || fail "no page of the short forms"

reproduce 0 --full he pareto
expect $'he\npareto'
grep -qx 'report --full -o results/report.html' "$folder/calls" || fail "no page of the results"

reproduce 0 --check
expect "$(sed 's/$/ short_form=true figures_only=true/' <<<"$checked")"
[ "$(grep -c '^check: ' "$folder/said")" = "$(wc -l <<<"$checked")" ] || fail "not all are checked"
if grep -q '^report ' "$folder/calls"; then fail "the check makes a page"; fi

MOVED=stability reproduce 1 --check stability convergence
expect $'stability short_form=true figures_only=true\nconvergence short_form=true figures_only=true'
grep -q 'kept -> NOT KEPT' "$folder/said" || fail "the row that moved is not named"

# With the portable code: in folders of their own, and only if the tools say that it is what they run.
mkdir -p "$folder/build/release/bin"
stand_in build/release/bin/vol-phantom 'echo "    \"simd\": \"${RUNS_ON-$PRECIS_SIMD}\"," >&2'
PRECIS_SIMD=portable MOVED=stability reproduce 1 --check stability convergence
grep -q 'kernels run on portable' "$folder/said" || fail "not said what the kernels run on"
[ -e "$folder/out/stability-short-portable/results/table.csv" ] && [ ! -e "$folder/out/stability-short" ] || fail "not in a folder of its own"
PRECIS_SIMD=portable RUNS_ON=AVX2 reproduce 2 --check stability
PRECIS_SIMD=portable reproduce 2 --full stability

BROKEN=he reproduce 2 he stability
expect 'he short_form=true'
grep -q 'he failed' "$folder/said" || fail "not said what failed"
