#!/usr/bin/env bash
# Converged references of the periodic benchmarks: runs in out/references, which go on where they were interrupted.
#
#   validation/references/run.sh            all of them, about an hour and a half of one core
#   validation/references/run.sh NAME…      those whose names begin so
#
# Each begins from the last state of the run in the column "from", so that short runs on fine meshes are periodic.
# `validation/references/evaluate.py out/references` makes the tables and histories of this directory from them.
set -euo pipefail
cd "$(dirname "$0")/../.."

finest='space.velocity=Q4 mesh.grading=2 newton.tolerance=1e-6'
# name | case | from | settings
runs="
fsi3-start | fsi3 |            | mesh.refine=1 newton.tolerance=1e-5 time.end=8
fsi3-1     | fsi3 | fsi3-start | $finest mesh.refine=1 time.scheme=esdirk3 time.step=0.008 time.end=11
fsi3-0     | fsi3 | fsi3-1     | $finest mesh.refine=0 time.scheme=esdirk3 time.step=0.008 time.end=14
fsi3-2     | fsi3 | fsi3-1     | $finest mesh.refine=2 time.scheme=esdirk3 time.step=0.008 time.end=13
fsi3-k     | fsi3 | fsi3-1     | $finest mesh.refine=1 time.scheme=esdirk3 time.step=0.004 time.end=12.6
fsi3-q3    | fsi3 | fsi3-1     | $finest mesh.refine=2 space.velocity=Q3 time.scheme=esdirk3 time.step=0.008 time.end=13
fsi2-start | fsi2 |            | mesh.refine=1 newton.tolerance=1e-5 time.end=15
fsi2-1     | fsi2 | fsi2-start | $finest mesh.refine=1 time.scheme=esdirk3 time.step=0.016 time.end=20
fsi2-0     | fsi2 | fsi2-1     | $finest mesh.refine=0 time.scheme=esdirk3 time.step=0.016 time.end=25
fsi2-2     | fsi2 | fsi2-1     | $finest mesh.refine=2 motion.model=biharmonic time.scheme=esdirk3 time.step=0.016 time.end=24
fsi2-k     | fsi2 | fsi2-1     | $finest mesh.refine=1 time.scheme=esdirk3 time.step=0.008 time.end=23
fsi2-q3    | fsi2 | fsi2-1     | $finest mesh.refine=2 motion.model=biharmonic space.velocity=Q3 time.scheme=esdirk3 time.step=0.016 time.end=24
cfd3-start | cfd3 |            | mesh.refine=1 newton.tolerance=1e-5 time.end=10
cfd3-1     | cfd3 | cfd3-start | $finest mesh.refine=1 time.scheme=esdirk3 time.step=0.008 time.end=14
cfd3-0     | cfd3 | cfd3-1     | $finest mesh.refine=0 time.scheme=esdirk3 time.step=0.008 time.end=18
cfd3-2     | cfd3 | cfd3-1     | $finest mesh.refine=2 time.scheme=esdirk3 time.step=0.008 time.end=17
cfd3-k     | cfd3 | cfd3-1     | $finest mesh.refine=1 time.scheme=esdirk3 time.step=0.004 time.end=16
cfd3-q3    | cfd3 | cfd3-1     | $finest mesh.refine=2 space.velocity=Q3 time.scheme=esdirk3 time.step=0.008 time.end=17
csm3-0     | csm3 |            | $finest mesh.refine=0 time.step=0.00125
csm3-1     | csm3 |            | $finest mesh.refine=1 time.step=0.00125
csm3-2     | csm3 |            | $finest mesh.refine=2 time.step=0.00125
csm3-k     | csm3 |            | $finest mesh.refine=1 time.step=0.000625
csm3-q3    | csm3 |            | $finest mesh.refine=2 space.velocity=Q3 time.step=0.00125
"

undula=${UNDULA:-"cargo run --release --quiet --"}
out=${OUT:-out/references}
mkdir -p "$out"
while IFS='|' read -r name from_case from settings; do
    name=${name// /}
    [ -n "$name" ] || continue
    chosen=$([ $# = 0 ] && echo yes || true)
    for wanted in "$@"; do [[ "$name" == "$wanted"* ]] && chosen=yes; done
    [ -n "$chosen" ] || continue
    grep -qs '"status": "completed"' "$out/$name/summary.json" && continue
    arguments=()
    for setting in $settings output.fields-every=0 output.report=false; do arguments+=(--set "$setting"); done
    [ -z "${from// /}" ] || arguments+=(--set "initial.from=$out/${from// /}")
    [ ! -e "$out/$name/checkpoints" ] || arguments+=(--resume)
    echo "$name: $(date -u +%H:%M:%S)"
    $undula run ${from_case// /} -o "$out/$name" "${arguments[@]}" ${THREADS:+--threads $THREADS} --quiet
done <<< "$runs"
