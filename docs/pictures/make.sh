#!/bin/sh
# Makes the pictures of the manual's examples: docs/pictures/make.sh PROGRAM [NAME...], about ten minutes on one thread.
# Shortened where the picture does not need the whole run; fsi3, cylinder, pump, valve and hydrofoil came from whole runs.
set -e
program=$1
shift
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
one() { # name, picture, settings
    name=$1 picture=$2
    shift 2
    case " $names " in *" $name "*) ;; *) return 0 ;; esac
    "$program" run "$name" -o "$work/$name" --threads 1 --set output.report=false "$@" > "$work/$name.log" 2>&1
    # Pillow makes them small.
    python3 -c "import sys; from PIL import Image; i = Image.open(sys.argv[1]); w = round(min(i.width, 1100, 1000 * i.width / i.height)); i.convert('RGB').resize((w, round(
i.height * w / i.width)), Image.LANCZOS).quantize(128).save(sys.argv[2], optimize=True)" "$work/$name/plots/$picture.png" "$here/$name.png"
    echo "$name $(stat -c %s "$here/$name.png")"
}
names=${*:-csm1 csm2 csm3 cfd1 cfd2 cfd3 fsi1 fsi2 dfg-2d1 dfg-2d2 dfg-2d3 rotor flap cavity tube-2d dfg-3d1z dfg-3d3z cook land fsi-box tube}
one csm1 deformation
one csm2 deformation
one csm3 deformation --set time.end=0.45
one cfd1 speed
one cfd2 speed
one cfd3 speed --set time.end=6
one fsi1 speed
one fsi2 speed --set time.end=13.2
one dfg-2d1 speed
one dfg-2d2 speed --set time.end=6
one dfg-2d3 speed --set time.end=6
one rotor speed --set time.end=12
one flap speed --set time.end=0.6
one cavity speed --set time.end=7.5
one tube-2d speed --set time.end=6e-3
one cook surface-displacement
one land surface-displacement
one fsi-box surface-displacement --set mesh.grading=0
one dfg-3d1z speed
one dfg-3d3z speed --set time.end=5 --set time.step=0.02
one tube surface-displacement --set time.end=4e-3 --set output.fields-every=40
rm -rf "$work"
