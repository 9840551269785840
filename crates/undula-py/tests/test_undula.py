"""The module as people use it. `validation/python.sh` builds it, and runs this in an environment of its own."""

import base64
import importlib.util
import json
import math
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
import types

import numpy as np
import pytest
import undula

# Few cells, few steps, a beam that falls.
SMALL = {"mesh.refine": 0, "time.step": 0.01, "time.end": 0.05}


def small(name="csm3", **settings):
    return undula.Case(name).set({**SMALL, **settings})


def program(*arguments):
    """The command `undula` of the wheel."""
    command = shutil.which("undula", path=os.path.dirname(sys.executable)) or shutil.which("undula")
    return subprocess.run([command, *arguments], capture_output=True, text=True, check=False)


def table(text):
    """Columns of a history.csv, its numbers read by Python."""
    lines = text.splitlines()
    rows = [[float(x) for x in line.split(",")] for line in lines[1:]]
    return dict(zip(lines[0].split(","), np.array(rows).T))


# Cases ------------------------------------------------------------------------------------------------------------------


def test_a_case_is_a_name_a_file_a_text_or_a_dictionary(tmp_path):
    case = undula.Case("fsi3")
    assert case["fluid.density"] == 1000.0 and case.name == "fsi3" and "fsi3" in undula.cases()
    case["fluid.density"] = 900
    assert case["fluid.density"] == 900.0 and case["fluid"]["density"] == 900.0
    assert "density = 900.0" in case.toml and "fluid.density" in case and "fluid.colour" not in case
    path = tmp_path / "own.toml"
    path.write_text(case.toml)
    assert undula.Case(path).toml == undula.Case(case.toml).toml == undula.Case(str(path)).toml
    with pytest.raises(KeyError):
        case["fluid.colour"]
    box = undula.Case({
        "name": "channel",
        "mesh": {"generator": "box", "lower": [0, 0], "upper": [3.0, 1.0], "cells": np.array([3, 2])},
        "fluid": {"density": 1.0, "kinematic-viscosity": 0.1},
        "boundary": {
            "left": {"condition": "velocity", "velocity": ["4*y*(1 - y)", "0"]},
            "right.condition": "do-nothing", "bottom.condition": "no-slip", "top": {"condition": "no-slip"},
        },
    })
    run = box.run().finish()
    assert abs(run.at([1.5, 0.5])["velocity"][0] - 1.0) < 1e-6
    rigid = undula.Case("fsi3").set("solid", None)
    assert "solid" not in rigid and "solid" in undula.Case("fsi3")
    assert "kinematic-viscosity" in undula.keys("fluid.k*")
    copy = case.copy().set("fluid.density", 800)
    assert (copy["fluid.density"], case["fluid.density"]) == (800.0, 900.0)
    assert "cells" in case.check() and "Re" in case.check()


def test_mistakes_have_the_messages_of_the_program(tmp_path):
    wrong = undula.Case("fsi3").set({"fluid.density": -1, "mesh.fine": 2})
    with pytest.raises(undula.InputError) as raised:
        wrong.run()
    assert isinstance(raised.value, ValueError)
    assert "fluid.density=-1: expected a number above 0" in str(raised.value)
    assert "mesh.fine=2: unknown key" in str(raised.value)
    assert program("check", "fsi3", "--set", "fluid.density=-1").stderr.strip() in str(raised.value)
    with pytest.raises(undula.InputError, match="no such case or file: `fsi33`; did you mean `fsi3`"):
        undula.Case("fsi33").toml
    with pytest.raises(undula.InputError, match="own:2:13: mesh.generator = 7|case:2:13: mesh.generator = 7"):
        undula.Case("[mesh]\ngenerator = 7\n").toml
    with pytest.raises(undula.InputError, match="no case.toml"):
        undula.load(tmp_path)
    with pytest.raises(TypeError, match="expected a number"):
        undula.Case("fsi3")["fluid.density"] = 1j
    with pytest.raises(undula.InputError, match="boundary"):
        undula.Case("fsi3").set("boundary.elsewhere.condition", "no-slip").run()


# Runs -------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name, settings", [
    ("csm3", {}),
    ("fsi3", {"time.step": 0.02, "time.end": 0.1}),
    ("csm3", {"mesh.extrude": {"depth": 0.02, "layers": 1}}),
])
def test_a_run_has_the_bits_of_the_program(tmp_path, name, settings):
    case = undula.Case(name).set({**SMALL, **settings})
    own = tmp_path / "case.toml"
    own.write_text(case.toml)
    done = program("run", str(own), "-o", str(tmp_path / "program"), "--quiet")
    assert done.returncode == 0, done.stderr
    run = case.run()
    rows = list(run)
    expected = table((tmp_path / "program/history.csv").read_text())
    assert list(expected) == run.columns == list(rows[0])
    for column, values in run.history.items():
        assert np.array_equal(values, expected[column], equal_nan=True), column
        assert [row[column] for row in rows] == list(values) or np.isnan(values).any()
    with_files = case.run(tmp_path / "python", threads=1)
    assert with_files.finish() is with_files and with_files.ended
    assert (tmp_path / "python/history.csv").read_bytes() == (tmp_path / "program/history.csv").read_bytes()
    summary = json.loads((tmp_path / "program/summary.json").read_text())
    for key in ["status", "cells", "unknowns", "steps", "newton_steps", "jacobians", "functionals", "mass_balance"]:
        assert run.summary[key] == summary[key] == with_files.summary[key], key
    # Last fields of the program, and those in memory.
    loaded, now = undula.load(tmp_path / "program"), run.fields()
    written = loaded.fields()
    assert np.array_equal(now.points, written.points) and np.array_equal(now.cells, written.cells)
    for field, values in now.point_data.items():
        assert np.array_equal(values, written[field]), field
    assert loaded.columns == run.columns and loaded.rows[-1]["time"] == rows[-1].time
    point = [0.5, 0.2, 0.01][: now.dimension]
    assert np.array_equal(loaded.at(point)["displacement"], run.at(point)["displacement"])


def test_rows_are_mappings_and_histories_are_arrays():
    run = small().run()
    row = next(run)
    assert row.step == 1 and row.time == row["time"] == 0.01 and isinstance(row["newton_steps"], int)
    assert dict(row)["uy_A"] == row["uy_A"] < 0 and len(row) == len(run.columns)
    with pytest.raises(KeyError, match="there are step, time"):
        row["drag"]
    assert run.units["uy_A"] == "m" and run.history["uy_A"].shape == (1,)
    for row in run:
        if row.step == 3:
            break
    assert [row.step for row in run] == [4, 5] and run.step() is None
    assert run.history["step"].dtype == np.int64 and run.history["time"].dtype == float
    assert "uy_A" in repr(row) and "csm3" in repr(run)
    if importlib.util.find_spec("pandas"):
        frame = run.to_pandas()
        assert list(frame.columns) == run.columns and len(frame) == 5


def test_a_callback_sees_the_state_of_its_step_and_stops():
    run = small().run()
    seen = []

    def callback(row):
        seen.append((row["uy_A"], run.at([0.6, 0.2])["displacement"][1]))
        return len(seen) == 3

    run.finish(callback)
    assert len(seen) == 3 and all(abs(a - b) < 1e-12 for a, b in seen)
    assert run.finish(until=0.04).history["time"][-1] == pytest.approx(0.04)
    run.stop()
    assert run.ended and run.step() is None and run.summary["status"] == "interrupted"


def test_fields_have_shapes_and_cells():
    run = small("fsi3").run()
    next(run)
    fields = run.fields()
    n, m = len(fields.points), len(fields.cells)
    assert fields.points.shape == (n, 3) and fields["velocity"].shape == (n, 2) and fields["pressure"].shape == (n,)
    assert fields["solid"].shape == (m,) and set(fields["solid"]) == {0.0, 1.0}
    assert fields.cells.min() == 0 and fields.cells.max() == n - 1 and fields.time == 0.01
    # The area of all cells, by the shoelace formula, is that of the channel without the cylinder.
    x, y = fields.points[fields.cells][:, :, 0], fields.points[fields.cells][:, :, 1]
    area = 0.5 * np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1))
    assert area == pytest.approx(2.5 * 0.41 - math.pi * 0.05**2, rel=1e-3)
    tip = np.argmin(np.linalg.norm(fields.points[:, :2] - fields["deformation"] - [0.6, 0.2], axis=1))
    assert np.allclose(fields["deformation"][tip], run.at([0.6, 0.2])["displacement"], atol=1e-15)
    at = run.at((0.6, 0.2))
    assert at["velocity_gradient"].shape == (2, 2) and at["is_solid"] in (True, False)
    with pytest.raises(undula.InputError, match="9"):
        run.at([9.0, 9.0])
    with pytest.raises(undula.InputError, match="2 coordinates"):
        run.at([0.6, 0.2, 0.0])
    with pytest.raises(KeyError, match="there are velocity"):
        fields["temperature"]
    with pytest.raises(undula.InputError, match="written no fields"):
        run.fields(0.5)
    if importlib.util.find_spec("pyvista"):
        grid = fields.to_pyvista()
        assert grid.n_cells == m and grid.area == pytest.approx(area) and grid["velocity"].shape == (n, 3)
    if importlib.util.find_spec("meshio"):
        assert fields.to_meshio().cells[0].type == "quad"


def test_fields_of_a_run_with_files_are_found_by_time(tmp_path):
    run = small("csm3", **{"output.fields-every": 1}).run(tmp_path / "run")
    kept = {row.time: run.fields()["deformation"].copy() for row in run}
    loaded = undula.load(tmp_path / "run")
    assert list(loaded.times) == pytest.approx([0.0, 0.01, 0.02, 0.03, 0.04, 0.05])
    for time, values in kept.items():
        assert np.array_equal(loaded.fields(time)["deformation"], values)
        assert np.array_equal(run.fields(time)["deformation"], values)
    assert loaded.fields(0.0312).time == pytest.approx(0.03)
    assert os.path.getsize(run.report()) > 10_000 and all(os.path.getsize(path) for path in run.plot())
    assert loaded.case["mesh.refine"] == 0 and loaded.summary["status"] == "completed" and loaded.units["uy_A"] == "m"


def test_an_interrupted_run_goes_on_with_the_same_bits(tmp_path):
    whole = small().run(tmp_path / "whole").finish()
    with small().run(tmp_path / "parts") as run:
        for row in run:
            if row.step == 2:
                break
    assert run.ended and undula.load(tmp_path / "parts").summary["status"] == "interrupted"
    again = undula.load(tmp_path / "parts").resume()
    assert len(again.rows) == 2
    again.finish()
    assert (tmp_path / "parts/history.csv").read_bytes() == (tmp_path / "whole/history.csv").read_bytes()
    assert again.rows[-1]["uy_A"] == whole.rows[-1]["uy_A"]
    later = undula.load(tmp_path / "parts").resume(**{"time.end": 0.06})
    assert [row.step for row in later] == [6]
    with pytest.raises(undula.InputError, match="--force|completed"):
        small().run(tmp_path / "whole")
    small().run(tmp_path / "whole", force=True).stop()
    # A run that is forgotten ends as one that is stopped.
    forgotten = small().run(tmp_path / "forgotten")
    next(forgotten)
    del forgotten, run
    assert undula.load(tmp_path / "forgotten").summary["status"] == "interrupted"


def test_a_breakdown_is_an_exception_with_its_reason(tmp_path):
    heavy = {"solid.body-force": [0, -1e9], "time.max-halvings": 0, "newton.max-steps": 3}
    for directory in [None, tmp_path / "run"]:
        run = small("csm3", **heavy).run(directory)
        with pytest.raises(undula.Breakdown, match="no solution for the step"):
            run.finish()
        assert run.ended and run.summary["status"] == "breakdown"
    assert (tmp_path / "run/breakdown.txt").exists()


def test_the_interpreter_is_free_while_a_step_is_computed():
    run = undula.Case("fsi3").set({"mesh.refine": 2, "time.step": 0.01, "time.end": 0.03}).run(threads=1)
    ticks, going = [], True

    def tick():
        while going:
            ticks.append(time.perf_counter())
            time.sleep(0.002)

    thread = threading.Thread(target=tick)
    thread.start()
    begun = time.perf_counter()
    next(run)
    ended = time.perf_counter()
    going = False
    thread.join()
    inside = [t for t in ticks if begun < t < ended]
    assert len(inside) > 0.1 * (ended - begun) / 0.002, (len(inside), ended - begun)


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no timers")
def test_an_interrupt_ends_the_step_and_the_run_can_go_on():
    reference = small().run().finish()
    run = undula.Case("fsi3").set({"mesh.refine": 2, "time.step": 0.01}).run()
    former = signal.signal(signal.SIGALRM, lambda *_: (_ for _ in ()).throw(KeyboardInterrupt()))
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.3)
        with pytest.raises(KeyboardInterrupt):
            run.finish()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, former)
    steps = len(run.rows)
    assert not run.ended and next(run).step == steps + 1
    assert small().run().finish().history["uy_A"][-1] == reference.history["uy_A"][-1]


# Data and meshes --------------------------------------------------------------------------------------------------------


def test_boundary_data_are_functions_of_python():
    profile = "1.5*4*y*(0.41 - y)/0.41^2"
    settings = {"mesh.refine": 0, "time.step": 0.02, "time.end": 0.2}
    written = undula.Case("cfd3").set(settings).set("boundary.inflow.velocity", [f"{profile}*sin(t)^2", "0"])
    called = []

    def pulse(t):
        called.append(t)
        return math.sin(t) ** 2

    own = undula.Case("cfd3").set(settings).function("pulse", pulse)
    own["boundary.inflow.velocity"] = [f'{profile}*table("pulse", t)', "0"]
    first, second = written.run().finish(), own.run().finish()
    for column in first.columns:
        scale = np.abs(first.history[column]).max()
        assert np.allclose(first.history[column], second.history[column], rtol=0, atol=1e-9 * scale), column
    # Not at all nodes: at each time a few times.
    assert 10 <= len(set(called)) and len(called) < 20 * len(set(called))
    # A function as a value, here of the pressure at an outlet.
    drop = undula.Case("cfd3").set(settings)
    drop["boundary.outflow.pressure"] = lambda t: 10.0 * t
    same = undula.Case("cfd3").set(settings).set("boundary.outflow.pressure", "10*t")
    a, b = drop.run().finish().history, same.run().finish().history
    assert np.allclose(a["drag"], b["drag"], rtol=1e-9)


def test_a_displacement_that_a_function_gives_has_its_velocity():
    base = {
        "mesh": {"generator": "box", "lower": [0, 0], "upper": [1.0, 1.0], "cells": [2, 2]},
        "solid": {"region": "fluid", "density": 1.0, "young": 1.0, "poisson": 0.3},
        "boundary": {
            "left": {"condition": "displacement"},
            "right": {"condition": "traction-free"}, "top": {"condition": "traction-free"},
            "bottom": {"condition": "traction-free"},
        },
        "time": {"step": 0.1, "end": 0.3, "scheme": "bdf2"},
    }
    own = undula.Case(base).set("boundary.left.displacement", [lambda t: 0.1 * math.sin(t), 0])
    run = own.run().finish()
    at = run.at([0.0, 0.5])
    assert at["displacement"][0] == pytest.approx(0.1 * math.sin(0.3), rel=1e-12)
    assert at["velocity"][0] == pytest.approx(0.1 * math.cos(0.3), rel=1e-8)


def test_what_a_function_raises_is_raised():
    ended = False

    def broken(t):
        if ended:
            raise LookupError("no more data")
        return 0.1 * t

    case = undula.Case("cfd3").set({"mesh.refine": 0, "time.step": 0.02, "time.end": 0.2})
    case["boundary.inflow.velocity"] = [broken, 0]
    run = case.run()
    next(run)
    ended = True
    with pytest.raises(LookupError, match="no more data"):
        run.finish()
    assert len(run.rows) == 1 and run.ended
    # One that is asked before the run.
    with pytest.raises(LookupError):
        case.copy().set("mesh.refine", 0).run()
    wrong = undula.Case("cfd3").set("boundary.inflow.velocity", [lambda t: "fast", 0])
    with pytest.raises(TypeError):
        wrong.set("mesh.refine", 0).run().finish()


def unit_square(n):
    """Points and cells of n × n quadrilaterals, edges of the four sides."""
    grid = np.linspace(0.0, 1.0, n + 1)
    points = np.array([[x, y] for y in grid for x in grid])
    number = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    cells = np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], axis=-1).reshape(-1, 4)
    sides = {"foot": number[0], "top": number[-1], "left": number[:, 0], "right": number[:, -1]}
    return points, cells, {name: np.stack([side[:-1], side[1:]], axis=1) for name, side in sides.items()}


def test_meshes_come_from_arrays(tmp_path):
    points, cells, sides = unit_square(4)
    boundaries = {"foot": sides["foot"], "rest": np.concatenate([sides["top"], sides["left"], sides["right"]])}
    path = undula.write_mesh(tmp_path / "square.msh", points, {"solid": cells}, boundaries)
    body = {"solid": {"density": 1.0, "young": 1.0, "poisson": 0.3, "body-force": [0.0, -0.01]}}
    body["boundary"] = {"foot": {"condition": "clamped"}}
    own = undula.Case({"mesh": {"file": path}, **body}).set("boundary.rest.condition", "traction-free")
    sides = {f"boundary.{side}.condition": "traction-free" for side in ["left", "right", "top"]}
    box = {"mesh": {"generator": "box", "lower": [0, 0], "upper": [1, 1], "cells": [4, 4]}}
    box["solid"] = {**body["solid"], "region": "fluid"}
    built = undula.Case(box).set({"boundary.bottom.condition": "clamped", **sides})
    a, b = (case.run().finish().at([0.3, 1.0])["displacement"] for case in (own, built))
    assert a[1] < 0 and np.allclose(a, b, rtol=1e-10, atol=1e-14)
    with pytest.raises(ValueError, match="numbers of points from 0 to 24"):
        undula.write_mesh(path, points, {"solid": cells + 1})
    with pytest.raises(ValueError, match="foot: expected rows"):
        undula.write_mesh(path, points, {"solid": cells}, {"foot": [[0, 1, 2, 3, 4]]})
    block = types.SimpleNamespace(type="quad", dim=2, data=cells)
    half = {"gmsh:physical": [np.arange(len(cells)) % 2 + 1]}
    unnamed = types.SimpleNamespace(points=points, cells=[block], cell_data=half, field_data={"solid": [1, 2]})
    with pytest.raises(ValueError, match="cells of quad in group 2, which has no name"):
        undula.write_mesh(path, unnamed)
    if importlib.util.find_spec("meshio"):
        import meshio

        undula.write_mesh(path, points, {"solid": cells}, boundaries)
        again = undula.write_mesh(tmp_path / "again.msh", meshio.read(path))
        assert np.allclose(own.copy().set("mesh.file", again).run().finish().at([0.3, 1.0])["displacement"], a)


# Studies, pictures, the command -------------------------------------------------------------------------------------------


def test_a_study_runs_all_combinations(tmp_path):
    base = undula.Case("csm1").set("mesh.refine", 0)
    study = undula.study(base, over={"solid.mu": [0.5e6, 1e6], "space.velocity": ["Q2", "Q3"]}, directory=tmp_path)
    settings = [(run.settings["solid.mu"], run.settings["space.velocity"]) for run in study]
    assert settings == [(0.5e6, "Q2"), (0.5e6, "Q3"), (1e6, "Q2"), (1e6, "Q3")]
    assert all(run.error is None and run.summary["status"] == "completed" for run in study)
    alone = base.copy().set({"solid.mu": 1e6, "space.velocity": "Q3"}).run().finish()
    assert study[3]["uy_A"] == alone.rows[-1]["uy_A"] and abs(study[1]["uy_A"]) > abs(study[3]["uy_A"])
    assert undula.load(tmp_path / "3").rows[-1]["uy_A"] == study[3]["uy_A"]
    with pytest.raises(undula.InputError, match="solid.mu=-1"):
        undula.study(base, over={"solid.mu": [-1]})
    # One that goes wrong does not spoil the others.
    force = {"time.max-halvings": 0, "newton.max-steps": 8}
    mixed = undula.study(small("csm3", **force), over={"solid.body-force": [[0, -2], [0, -1e9]]})
    assert mixed[0].error is None and "no solution for the step" in mixed[1].error


def test_cases_and_runs_show_their_pictures():
    png = b"\x89PNG"
    case = small("fsi3")
    assert case._repr_png_().startswith(png)
    shown = case._repr_html_()
    assert base64.b64encode(png)[:4].decode() in shown and "Re" in shown
    run = case.run()
    next(run)
    assert run._repr_png_().startswith(png) and run._repr_png_() != case._repr_png_()
    assert small("csm3").run().finish()._repr_png_().startswith(png)
    assert small("csm3", **{"mesh.extrude": {"depth": 0.02, "layers": 1}})._repr_png_().startswith(png)


def test_the_wheel_has_the_program():
    said = program("check", "fsi3")
    assert said.returncode == 0 and said.stdout == undula.Case("fsi3").check()
    assert program("check", "fsi33").returncode == 2
    assert program("--version").stdout.strip() == f"undula {undula.__version__}"


def test_everything_public_is_documented():
    for name in undula.__all__:
        thing = getattr(undula, name)
        assert thing.__doc__, name
        for attribute, value in vars(thing).items() if isinstance(thing, type) else ():
            if not attribute.startswith("_") and (callable(value) or isinstance(value, property)):
                assert value.__doc__, f"{name}.{attribute}"
