#!/usr/bin/env bash
# FSI1 under refinement and grading in both pressure spaces: writes validation/fsi1.md. About ten minutes.
set -euo pipefail
cd "$(dirname "$0")/.."
undula=${UNDULA:-target/release/undula}
{
    echo "# FSI1 under refinement"
    echo
    echo "Values of \`validation/fsi1_series.sh\`, $(date -u +%F), $(lscpu | sed -n 's/^Model name: *//p'), $(nproc) cores."
    echo "\`refine\` is the number of uniform refinements. \`grading\` is the number of rings of cells of half the size around the"
    echo "two corners of the beam tip. h is the smallest cell there. Deviations are relative to the independent values below."
    echo
    echo "| pressure | refine | grading | h (m) | unknowns | drag (N/m) | lift (N/m) | u_x(A) (m) | u_y(A) (m) | deviations (%) |"
    echo "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |"
    for pressure in P1dc Q1; do
        for levels in "0 0" "1 0" "2 0" "3 0" "1 3" "2 3" "3 3" "1 6" "2 6" "3 6"; do
            read -r refine grading <<< "$levels"
            dir=out/validation/fsi1-series/$pressure-$refine-$grading
            [ -f "$dir/summary.json" ] || "$undula" run fsi1 --quiet --set mesh.refine="$refine" \
                --set mesh.grading="$grading" --set space.pressure="$pressure" -o "$dir" >&2
            python3 - "$dir" "$pressure" "$refine" "$grading" <<'P'
import json, sys
s = json.load(open(sys.argv[1] + "/summary.json"))
f = s["functionals"]
reference = {"drag": 14.2940, "lift": 0.76475, "ux_A": 2.2681e-5, "uy_A": 8.1859e-4}
h = 0.01 / 2 ** (int(sys.argv[3]) + int(sys.argv[4]))
deviation = ", ".join("%+.3f" % (100 * (f[k]["last"] / v - 1)) for k, v in reference.items())
print("| %s | %s | %s | %.1e | %d | %.5f | %.6f | %.5e | %.5e | %s |" % (*sys.argv[2:5], h, s["unknowns"]["total"],
      f["drag"]["last"], f["lift"]["last"], f["ux_A"]["last"], f["uy_A"]["last"], deviation))
P
        done
    done
    echo
    echo "| published | drag | lift | u_x(A) | u_y(A) | source |"
    echo "| --- | --- | --- | --- | --- | --- |"
    echo "| independent | 14.2940 | 0.76475 | 2.2681e-5 | 8.1859e-4 | NGSolve, P_k-P_k-P_(k-1) on curved triangles graded to 1e-6 at the corners |"
    echo "| featflow 7+0 | 14.29426 | 0.763746 | 2.270493e-5 | 8.208773e-4 | Q2-Q2-P1dc, 19 320 832 unknowns |"
} > validation/fsi1.md.new
mv validation/fsi1.md.new validation/fsi1.md
