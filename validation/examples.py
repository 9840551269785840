#!/usr/bin/env python3
"""The examples beside closed forms and under refinement; writes validation/examples.md. About a quarter of an hour.

    UNDULA=target/release/undula OUT=out/validation/examples validation/examples.py

Runs that are there already are not repeated.
"""

import csv
import json
import math
import os
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent
UNDULA = os.environ.get("UNDULA", str(ROOT / "target/release/undula"))
OUT = pathlib.Path(os.environ.get("OUT", str(ROOT / "out/validation/examples")))
FOIL = str(ROOT / "examples/hydrofoil.toml")


def run(case, name, *sets):
    """Columns of the history of a run, as lists; fields only at the end."""
    place = OUT / name
    if not (place / "summary.json").is_file():
        more = [word for pair in (*sets, "output.fields-every=0") for word in ("--set", pair)]
        subprocess.run([UNDULA, "run", case, "--quiet", "--threads", "1", *more, "-o", str(place)],
                       check=True, stdout=subprocess.DEVNULL)
    with open(place / "history.csv", encoding="utf-8") as file:
        rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    with open(place / "summary.json", encoding="utf-8") as file:
        unknowns = json.load(file)["unknowns"]["total"]
    return {key: [row[key] for row in rows] for key in rows[0]}, unknowns


def modes(*sets):
    """First frequencies in vacuum and with the fluid."""
    more = [word for pair in sets for word in ("--set", pair)]
    text = subprocess.run([UNDULA, "modes", FOIL, "--count", "3", *more], check=True, capture_output=True, text=True)
    rows = [line.split() for line in text.stdout.splitlines()]
    return [[float(x) for x in row[1:]] for row in rows if len(row) == 3 and row[0].isdigit()]


def table(head, rows):
    print("| " + " | ".join(head) + " |")
    print("|" + " --- |" * len(head))
    for row in rows:
        print("| " + " | ".join(str(cell) for cell in row) + " |")
    print()


def cylinder():
    """The coefficients of the last period, beside those of the test."""
    exact = (2.546187603804, 3.523230323772)

    def row(cells, step, amplitude):
        name = f"cylinder-{cells[0]}-{step}-{amplitude}"
        sets = [f"mesh.cells=[{cells[0]},{cells[1]}]", f"time.step={step}",
                f'boundary.inner.displacement=["{amplitude}*sin(2*pi*t)", 0]']
        history, unknowns = run("cylinder", name, *sets)
        steps = round(1 / step)
        times, forces = history["force_time"][-steps:], history["force"][-steps:]
        scale = math.pi * amplitude * (2 * math.pi) ** 2
        part = lambda f: 2 / steps * sum(F * f(2 * math.pi * t) for t, F in zip(times, forces)) / scale
        mass, damping = part(math.sin), -part(math.cos)
        return [f"{cells[0]} × {cells[1]}", unknowns, step, amplitude, f"{mass:.5f}", f"{damping:.5f}",
                f"{100 * (mass / exact[0] - 1):+.3f}, {100 * (damping / exact[1] - 1):+.3f}"]

    rows = [row((24, 4), k, 0.01) for k in (0.04, 0.02, 0.01)]
    rows += [row((48, 8), k, 0.01) for k in (0.02, 0.01, 0.005)]
    rows += [row((48, 8), 0.01, a) for a in (0.001, 0.1, 0.3)]
    table(["cells", "unknowns", "step (s)", "amplitude (m)", "C_a", "C_d", "deviations (%)"], rows)


def pump():
    """Mean flow of a period by the wave length, extrapolated in the step."""
    rows = []
    for wave in (10, 20, 40):
        means = []
        for steps in (20, 40):
            form = f"0.5*ramp(t,{wave / 2})*sin(2*pi*(x-t)/{wave})"
            sets = [f"mesh.upper=[{wave},1]", "mesh.cells=[32,4]", f'boundary.top.displacement=[0,"{form}"]',
                    f"time.step={wave / steps}", f"time.end={2 * wave}"]
            history, _ = run("pump", f"pump-{wave}-{steps}", *sets)
            means.append(sum(history["flow"][steps:]) / steps)
        flow = (4 * means[1] - means[0]) / 3
        error = 3 * flow - 1
        order = f"{math.log2(rows[-1][-1] / error):.2f}" if rows else ""
        rows.append((wave, f"{flow:.6f}", f"{100 * error:+.3f}", order, error))
    table(["λ/a", "mean flow/(a c)", "deviation (%)", "order"], [row[:-1] for row in rows])


def valve():
    """Extremes of the second period."""
    rows = []
    for refine, step in ((0, 0.02), (0, 0.01), (1, 0.02), (1, 0.01), (2, 0.02)):
        history, unknowns = run("valve", f"valve-{refine}-{step}", f"mesh.refine={refine}", f"time.step={step}",
                                "time.end=2")
        steps = round(1 / step)
        tip, pressure = history["uy_tip"], history["pressure"]
        change = max(abs(a - b) for a, b in zip(tip[steps // 2:steps], tip[steps + steps // 2:]))
        rows.append([refine, unknowns, step, f"{-1e3 * min(tip[:steps]):.4f}", f"{-1e3 * min(tip[steps:]):.4f}",
                     f"{1e3 * max(tip[steps:]):.4f}", f"{1e3 * change:.4f}",
                     f"{min(pressure[steps:]):.3f}, {max(pressure[steps:]):.3f}", f"{min(history['min_J']):.2f}"])
    table(["refine", "unknowns", "step (s)", "opening, first period (mm)", "second period (mm)", "overshoot (mm)",
           "change of the second half (mm)", "pressure at the outlet (Pa)", "smallest J"], rows)


def hydrofoil():
    """Equilibrium in the stream, modes, and free oscillations in the fluid at rest."""
    nose, tail = (-0.3486681443, 0.03050451), (0.6475265538, -0.0566512328)
    chord = [b - a for a, b in zip(nose, tail)]
    rows = []
    for refine in (0, 1, 2):
        history, unknowns = run(FOIL, f"foil-{refine}", f"mesh.refine={refine}")
        at = {key: values[0] for key, values in history.items()}
        # The chord keeps its length but for 1e-5 of it.
        moved = (at["uy_tail"] - at["uy_nose"] + chord[1]) / math.hypot(*chord)
        turned = math.asin(moved) - math.atan2(chord[1], chord[0])
        rows.append([refine, unknowns, f"{at['drag']:.5f}", f"{at['lift']:.5f}", f"{at['moment']:.6f}",
                     f"{math.degrees(turned):.4f}"])
    table(["refine", "unknowns", "drag (N/m)", "lift (N/m)", "moment (N)", "turned (degrees)"], rows)
    rows = []
    for refine in (0, 1, 2):
        found = modes(f"mesh.refine={refine}")
        rows.append([refine] + [f"{f:.5f}" for pair in found for f in pair])
    table(["refine", "pitch, vacuum (Hz)", "in the fluid", "second, vacuum", "in the fluid", "third, vacuum",
           "in the fluid"], rows)
    rows = []
    for viscosity in (5e-3, 5e-4, 5e-5):
        sets = ["boundary.inflow.condition=slip", 'initial.velocity=["-0.01*y", "0.01*x"]', "time.step=0.025",
                "time.end=8", f"fluid.kinematic-viscosity={viscosity}", "mesh.refine=1"]
        history, _ = run(FOIL, f"swing-{viscosity}", *sets)
        t, u = history["time"], history["uy_tail"]
        zeros = [t[i] - u[i] * (t[i + 1] - t[i]) / (u[i + 1] - u[i]) for i in range(len(u) - 1) if u[i] < 0 <= u[i + 1]]
        rows.append([viscosity, f"{(len(zeros) - 1) / (zeros[-1] - zeros[0]):.4f}"])
    table(["viscosity (m²/s)", "frequency of a swing in the fluid at rest (Hz)"], rows)


def aneurysm():
    """The largest values of one beat of the heart."""
    history, unknowns = run(str(ROOT / "examples/aneurysm.toml"), "aneurysm")
    row = [unknowns, f"{max(history['pressure']):.0f}", f"{-1e6 * min(history['ux_dome']):.2f}",
           f"{1e-3 * max(history['stress']):.1f}", f"{max(history['wall-shear-stress']):.1f}"]
    table(["unknowns", "pressure at the inflow (Pa)", "top of the bulge (µm)", "stress in the wall (kPa)",
           "wall shear stress (Pa)"], [row])


def flap():
    """The tip at the times of the test."""
    history, _ = run("flap", "flap")
    at = lambda t: min(range(len(history["time"])), key=lambda i: abs(history["time"][i] - t))
    rows = [[t, f"{history['ux_tip'][at(t)]:.4f}", published] for t, published in
            ((0.3, 0.0884), (0.5, 0.1647), (0.7, 0.1951), (1.0, 0.1409))]
    table(["t (s)", "u_x of the tip (m)", "preCICE tutorials"], rows)


def cavity():
    """Extrema of the bottom behind 11 s."""
    history, _ = run("cavity", "cavity")
    t, u = history["time"], history["uy_mid"]
    turns = [i for i in range(1, len(u) - 1) if t[i] > 11 and (u[i] - u[i - 1]) * (u[i + 1] - u[i]) < 0]
    rows = [[f"{t[i]:.2f}", f"{u[i]:.3f}", published] for i, published in zip(turns, (0.162, 0.254, 0.196, 0.267))]
    table(["t (s)", "u_y of the middle (m)", "Valdés 2007"], rows)


TEXT = """# Examples

Cases that people bring, beside closed forms and under refinement. Values of `validation/examples.py`. `cargo test`
asserts them on coarse meshes.
"""

print_to = ROOT / "validation/examples.md"
if __name__ == "__main__":
    import contextlib
    import io

    OUT.mkdir(parents=True, exist_ok=True)
    page = io.StringIO()
    with contextlib.redirect_stdout(page):
        print(TEXT)
        print("""## cylinder

![Speed around the cylinder](../docs/pictures/cylinder.png)

A cylinder of radius R = 1 m oscillates with u = a sin(ω t), ω = 2π/s, inside a fixed one of 2 m; ν = 0.5 m²/s. The
force of small motions is −π ρ R² (C_a u'' + ω C_d u'), C_a = 2.54619 and C_d = 3.52323 in closed form (modified Bessel
functions: Stokes 1851; Chen, Wambsganss and Jendrzejczyk 1976). C_a, C_d of the third period:
""")
        cylinder()
        print("""The error of the steps is of second order, that of the mesh of fourth. At a = 0.1 m and 0.3 m the motion
is no longer small.

## pump

![Speed in the pump](../docs/pictures/pump.png)

One wave of the length λ and the amplitude a/2 in a channel of the half height a, without a rise in pressure. For long
waves the mean flow of a half is 3 φ² a c/(2 + φ²) = a c/3 (Shapiro, Jaffrin and Weinberg 1969), to (a/λ)². Second
period, extrapolated from 20 and 40 steps:
""")
        pump()
        print("""## valve

![Speed in the open valve](../docs/pictures/valve.png)

Two leaflets in a flow of 0.1 sin²(πt) m/s in the mean, an RCR circuit behind. *Opening*: how far the lower tip goes
down; the gap between the tips is 4 mm at rest. *Overshoot*: how far it comes up.
""")
        valve()
        print("""The built-in case has `refine` 0 and 0.01 s. The circuit follows C dP/dt = Q − P/R_d of the computed flow by
the scheme to rounding, and the same equation solved exactly to second order in the step (`tests/it/valve.rs`).

## hydrofoil

![Speed around the hydrofoil](../docs/pictures/hydrofoil.png)

`examples/hydrofoil.toml`: NACA 0012, chord 1 m, 5° nose up in a stream of 1 m/s in a channel of 3 m, Re = 200, on
springs of 565.3 N/m² and 0.508 N at its axis. Drag, lift and moment about the axis are those of the springs to 1e-6 (`tests/it/hydrofoil.rs`). The modes in vacuum are those of a rigid foil, det(K − ω² M) = 0, to 1e-5 if it is
stiffer. A swing in the fluid at rest comes near to the mode with the added mass, which has no viscosity, as the
viscosity falls.
""")
        hydrofoil()
        print("""## aneurysm

![Speed in the aneurysm](../docs/pictures/aneurysm.png)

`examples/aneurysm.toml`, P2-P1 on tetrahedra, k = 0.01 s: largest values of a beat. The wall rests in the flow of the
start to 1e-18 m, and the circuit follows its equation (`tests/it/aneurysm.rs`); with `stabilization.transport` the
pressure of the start is not that of a step in time, and the wall moves by 1e-10 m.
""")
        aneurysm()
        print("""## flap

The perpendicular flap of the preCICE tutorials, `undula run flap`: within 2 % (`tests/it/own_problems.rs`).
""")
        flap()
        print("""## cavity

Extrema of the flexible bottom, `undula run cavity`: within 10 % of those of Valdés 2007, section 6.2
(`tests/it/own_problems.rs`). The published ones are read off a figure.
""")
        cavity()
    print_to.write_text(page.getvalue().rstrip() + "\n", encoding="utf-8")
    print(print_to)
