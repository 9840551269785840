#!/usr/bin/env bash
# Long validation: runs the benchmarks at full length and keeps what they say in validation/*.txt.
#
#   validation/run.sh            all of them, several hours on one core
#   validation/run.sh NAME…      those named, see the table below
#   validation/run.sh --collect  only write the texts of runs that are already in out/validation
#
# Results lie in out/validation/NAME. A run that was interrupted is continued.
set -euo pipefail
cd "$(dirname "$0")/.."

# name | case | settings
runs='
cfd1      | cfd1    | mesh.refine=3
cfd2      | cfd2    | mesh.refine=3
cfd3      | cfd3    | mesh.refine=2 time.step=0.005
csm1      | csm1    | mesh.refine=2
csm2      | csm2    | mesh.refine=2
csm3      | csm3    | mesh.refine=1 time.step=0.005
fsi1      | fsi1    | mesh.refine=2 mesh.grading=3
fsi1-q1   | fsi1    | mesh.refine=2 mesh.grading=3 space.pressure=Q1
fsi2-20k  | fsi2    | mesh.refine=1 time.step=0.0025 time.end=15
fsi2-77k  | fsi2    | mesh.refine=2 time.step="if(t<6,0.005,0.0025)" time.end=15
fsi3-20k  | fsi3    | mesh.refine=1 time.step=0.0025 time.end=8
fsi3-77k  | fsi3    | mesh.refine=2 time.step=0.0025
dfg-2d1   | dfg-2d1 | mesh.refine=4
dfg-2d2   | dfg-2d2 | mesh.refine=2 time.step=0.005
dfg-2d3   | dfg-2d3 | mesh.refine=2 time.step=0.005
'

undula=${UNDULA:-target/release/undula}
[ "${1:-}" = --collect ] || cargo build --release
collect=false
if [ "${1:-}" = --collect ]; then collect=true; shift; fi
wanted=" $* "

field() { python3 -c "import json,sys; s=json.load(open('$1/summary.json')); print($2)"; }

while IFS='|' read -r name case settings; do
    name=${name// /}; case=${case// /}
    [ -n "$name" ] || continue
    [ "$wanted" = "  " ] || [[ "$wanted" == *" $name "* ]] || continue
    dir=out/validation/$name
    sets=(); for s in $settings; do sets+=(--set "$s"); done
    if ! $collect; then
        resume=()
        [ -f "$dir/summary.json" ] && [ "$(field "$dir" "s['status']")" != completed ] && resume=(--resume)
        "$undula" run "$case" "${sets[@]}" -o "$dir" "${resume[@]}"
    fi
    [ -f "$dir/summary.json" ] || continue
    {
        echo "undula run $case ${sets[*]}"
        echo
        echo "date      $(date -u -r "$dir/summary.json" +%F)"
        echo "machine   $(lscpu | sed -n 's/^Model name: *//p'), $(nproc) cores, shared"
        echo "commit    $(git rev-parse --short HEAD)"
        field "$dir" "'status    %s\ncells     %d\nunknowns  %d (velocity %d, deformation %d, pressure %d)' % (s['status'], s['cells'], s['unknowns']['total'], s['unknowns']['velocity'], s['unknowns']['deformation'], s['unknowns']['pressure'])"
        field "$dir" "'steps     %d, Newton steps %d, Jacobians %d\ntime      %.0f s on %d thread(s), peak memory %.0f MB' % (s['steps'], s['newton_steps'], s['jacobians'], s['wall_seconds'], s['threads'], (s['peak_memory_bytes'] or 0) / 1e6)"
        echo
        "$undula" compare "$dir"
    } > "validation/$name.txt"
    echo "validation/$name.txt"
done <<< "$runs"
