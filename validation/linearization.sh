#!/usr/bin/env bash
# Section 5.2.3: linearisations and ways to differentiate in developed motion of fsi3, 100 steps from t = 5 s.
# Prints Newton iterations and Jacobians of each; the residuals of every iteration are in OUT/NAME.log.
set -euo pipefail
cd "$(dirname "$0")/.."
undula=${UNDULA:-target/release/undula}
out=${OUT:-out/validation/linearization}
common=(--threads 1 --set mesh.refine=0 --set time.shift=2)
mkdir -p "$out"
[ -d "$out/base" ] || "$undula" run fsi3 "${common[@]}" --set time.end=5 -o "$out/base" --quiet

# one NAME SETTING…
one() {
    local name=$1 sets=()
    shift
    for s in "$@"; do sets+=(--set "$s"); done
    rm -rf "${out:?}/$name"
    cp -r "$out/base" "$out/$name"
    "$undula" run fsi3 "${common[@]}" --set time.end=5.5 "${sets[@]}" -o "$out/$name" --resume --verbose 2> "$out/$name.log" > "$out/$name.out"
    awk -F, -v name="$name" 'NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
        $at["time"] > 5.0001 { n += $at["newton_steps"]; j += $at["jacobians"]; if ($at["newton_steps"] > m) m = $at["newton_steps"] }
        END { printf "%-12s iterations %5d, at most %3d, Jacobians %5d\n", name, n, m, j }' "$out/$name/history.csv"
}

l=newton.linearization j=newton.jacobian rate=newton.rate-max
one exact $l=newton $j=analytic $rate=0
one gamma-0.2 $l=newton $j=analytic $rate=0.2
one gamma-0.5 $l=newton $j=analytic $rate=0.5
one automatic $l=newton $j=automatic $rate=0.2
for epsilon in 1e-2 1e-4 1e-6 1e-9 1e-12; do
    one fd-$epsilon $l=newton $j=finite-difference newton.epsilon=$epsilon $rate=0.2
done
one fd-central $l=newton $j=finite-difference newton.difference=central $rate=0.2
for linearization in reduced fixed-point condensed; do
    one $linearization-0 $l=$linearization $rate=0 newton.max-steps=100
    one $linearization $l=$linearization $rate=0.2 newton.max-steps=100
done
one defaults
one secants newton.secants=8
