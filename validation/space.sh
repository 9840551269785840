#!/usr/bin/env bash
# The built-in cases of space on several meshes: the tables of validation/space.md, about two and a half hours on two cores.
#
#   validation/space.sh            all of them
#   validation/space.sh NAME…      the cases named
set -euo pipefail
cd "$(dirname "$0")/.."

# case | settings
runs='
cook     | mesh.refine=0
cook     | mesh.refine=1
cook     | mesh.refine=2
cook     | mesh.refine=3
cook     | mesh.refine=4
dfg-3d1z | mesh.extrude.layers=2 mesh.extrude.grading=0
dfg-3d1z | mesh.extrude.layers=4 mesh.extrude.grading=0
dfg-3d1z | mesh.extrude.layers=8 mesh.extrude.grading=0
dfg-3d1z | mesh.extrude.layers=16 mesh.extrude.grading=0
dfg-3d1z | mesh.refine=0
dfg-3d1z | mesh.extrude.layers=8 mesh.extrude.grading=2
dfg-3d1z | mesh.extrude.layers=8 mesh.extrude.grading=3
dfg-3d1z | mesh.extrude.layers=16 mesh.extrude.grading=2
dfg-3d1z | space.velocity=Q3 space.pressure=P2dc linear.solver=multifrontal
dfg-3d1z | space.velocity=Q3 space.pressure=P2dc linear.solver=multifrontal mesh.extrude.layers=8 mesh.extrude.grading=2
dfg-3d1z | mesh.refine=1 mesh.extrude.layers=4 mesh.extrude.grading=0
dfg-3d1z | mesh.refine=1 mesh.extrude.layers=6 mesh.extrude.grading=0
dfg-3d1z | mesh.refine=1
dfg-3d1z | mesh.refine=1 mesh.extrude.layers=8 mesh.extrude.grading=2
validation/dfg-3d1z-half.toml | mesh.refine=0
validation/dfg-3d1z-half.toml | mesh.extrude.grading=2
validation/dfg-3d1z-half.toml | mesh.extrude.layers=8 mesh.extrude.grading=2
validation/dfg-3d1z-half.toml | mesh.refine=1
dfg-3d3z | time.step=0.02 linear.solver=multifrontal
dfg-3d3z | time.step=0.02 linear.solver=multifrontal time.end=5 mesh.refine=1
dfg-3d3z | time.step=0.02 linear.solver=multifrontal time.end=4.5 mesh.refine=1 mesh.extrude.layers=8 mesh.extrude.grading=2
fsi-box  | mesh.grading=0
fsi-box  | mesh.grading=1
fsi-box  | mesh.grading=2
tube     | mesh.cells=[40,8,1] mesh.grading=0 time.end=8e-3 time.shift=50
tube     | mesh.cells=[40,16,1] mesh.grading=0 time.end=8e-3 time.shift=50
tube     | mesh.cells=[50,8,1] mesh.grading=2 time.shift=50 time.end=1.1e-2
tube     | time.end=1.1e-2
tube     | mesh.cells=[50,8,1] mesh.grading=3 time.end=6e-3 time.shift=50
tube     | mesh.cells=[60,8,1] mesh.grading=3 time.step=5e-5 time.end=5.2e-3 time.shift=100
land     | mesh.cells=[10,1,1]
land     | mesh.cells=[20,2,2]
land     | mesh.cells=[40,4,4]
land     | mesh.cells=[10,1,1] space.velocity=P2
land     | mesh.cells=[10,1,1] space.velocity=P3
land     | mesh.cells=[10,2,2] space.velocity=P2
land     | mesh.cells=[20,2,2] space.velocity=P2
fsi-box  | mesh.grading=0 space.velocity=P2
fsi-box  | mesh.grading=0 space.velocity=P3
fsi-box  | mesh.grading=0 space.velocity=P2-bubble
fsi-box  | mesh.grading=1 space.velocity=P2
tube     | mesh.cells=[50,8,1] mesh.grading=2 time.step=5e-4 time.end=8e-3 time.shift=10
tube     | mesh.cells=[50,8,1] mesh.grading=2 time.step=5e-4 time.end=8e-3 space.velocity=P2 time.shift=10
tube     | mesh.cells=[20,8,1] mesh.grading=0 time.step=5e-4 time.end=8e-3 time.shift=10
tube     | mesh.cells=[20,8,1] mesh.grading=0 time.step=5e-4 time.end=8e-3 space.velocity=P2-bubble time.shift=10
tube-2d  | mesh.refine=0 time.end=9e-3
tube-2d  | mesh.refine=1 time.end=9e-3
tube-2d  | mesh.refine=1 time.end=9e-3 time.step=2.5e-5
tube-2d  | mesh.refine=2 time.end=8e-3
tube-2d  | mesh.refine=2 time.end=8e-3 time.step=2.5e-5
'

undula=${UNDULA:-target/release/undula}
[ -n "${UNDULA:-}" ] || cargo build --release
wanted=" $* "

while IFS='|' read -r case settings; do
    case=${case// /}
    [ -n "$case" ] || continue
    [ "$wanted" = "  " ] || [[ "$wanted" == *" $case "* ]] || continue
    dir=out/space/$case-$(echo "$settings" | tr -c 'A-Za-z0-9\n' '-')
    sets=(); for s in $settings; do sets+=(--set "$s"); done
    "$undula" run "$case" "${sets[@]}" -o "$dir" > /dev/null
    python3 - "$dir" "$case" "$settings" << 'EOF'
import csv, json, sys
directory, case, settings = sys.argv[1:]
s = json.load(open(directory + "/summary.json"))
rows = list(csv.DictReader(line for line in open(directory + "/history.csv") if not line.startswith("#")))
values = {name: f["last"] for name, f in s["functionals"].items()}
if case.startswith("tube"):
    largest = max(rows, key=lambda row: float(row["u_r"]))
    least = min(rows, key=lambda row: float(row["u_z"]))
    values = {"max u_r": float(largest["u_r"]), "at": float(largest["time"]), "min u_z": float(least["u_z"])}
shown = ", ".join(f"{name} {value:.7g}" for name, value in values.items())
print(f"{case} | {settings.strip()} | {s['cells']} | {s['unknowns']['total']} | {shown} | {s['newton_steps']} | "
      f"{s['jacobians']} | {s['wall_seconds']:.1f} s | {(s['peak_memory_bytes'] or 0) / 1e6:.0f} MB", flush=True)
EOF
done <<< "$runs"
