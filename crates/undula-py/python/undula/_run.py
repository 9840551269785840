"""Runs: what is computed step by step, and what a run has left in its directory."""

from __future__ import annotations

import atexit
import json
import os
import weakref
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _undula
from ._fields import Fields

if TYPE_CHECKING:
    from ._case import Case

_FIRST = ("step", "time", "force_time")
_LAST = ("min_J", "newton_steps", "jacobians")
_COUNTS = ("step", "newton_steps", "jacobians", "linear_iterations")


class Row(Mapping[str, Any]):
    """What one step gave, a mapping of the columns of ``history.csv``: ``row["drag"]``, ``row.time``.

    ``step``; ``time`` [s]; ``force_time`` [s], to which pressures and forces belong; the functionals in the order of the
    case; ``min_J``, the smallest det(I + grad u); ``newton_steps`` and ``jacobians`` of the step.
    """

    __slots__ = ("_at", "_values")

    def __init__(self, at: dict[str, int], values: Sequence[Any]) -> None:
        self._at = at
        self._values = values

    def __getitem__(self, name: str) -> Any:
        try:
            return self._values[self._at[name]]
        except KeyError:
            raise KeyError(f"{name}; there are {', '.join(self._at)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._at)

    def __len__(self) -> int:
        return len(self._at)

    @property
    def step(self) -> int:
        """Number of the step, from 1; 0 of a stationary solution."""
        return self._values[0]

    @property
    def time(self) -> float:
        """Time [s]."""
        return self._values[1]

    def __repr__(self) -> str:
        return "<undula.Row " + ", ".join(f"{name} = {value:.6g}" for name, value in self.items()) + ">"


class _Results:
    """What a run in memory and one that was loaded have in common."""

    _columns: list[str]
    _values: list[tuple[Any, ...]]
    directory: str | None

    @property
    def columns(self) -> list[str]:
        """Names of the columns of the history."""
        return list(self._columns)

    @property
    def rows(self) -> list[Row]:
        """All rows so far."""
        at = {name: n for n, name in enumerate(self._columns)}
        return [Row(at, values) for values in self._values]

    @property
    def history(self) -> dict[str, np.ndarray]:
        """All rows so far as arrays of one number per step, by column; SI units, see :class:`Row`."""
        if not self._values:
            return {name: np.empty(0) for name in self._columns}
        columns = zip(self._columns, zip(*self._values))
        return {name: np.array(values, dtype=np.int64 if name in _COUNTS else float) for name, values in columns}

    def to_pandas(self) -> Any:
        """The history as a ``pandas.DataFrame`` with a row per step; needs the package pandas."""
        import pandas

        return pandas.DataFrame(self.history)

    # Files ----------------------------------------------------------------------------------------------------------

    @property
    def times(self) -> np.ndarray:
        """Times [s] of the fields that the run has written into its directory."""
        return np.array([time for time, _ in self._entries()])

    def _entries(self) -> list[tuple[float, str]]:
        if self.directory is None:
            return []
        collection = os.path.join(self.directory, "fields.pvd")
        if not os.path.exists(collection):
            return []
        found = ElementTree.parse(collection).getroot().iter("DataSet")
        return [(float(e.attrib["timestep"]), os.path.join(self.directory, e.attrib["file"])) for e in found]

    def _entry(self, t: float | None) -> tuple[float, str]:
        entries = self._entries()
        if not entries:
            raise _undula.InputError(
                "the run has written no fields: give `run` a directory, and the case `output.fields-every` or "
                "`output.fields-interval`"
            )
        return entries[-1] if t is None else min(entries, key=lambda entry: abs(entry[0] - t))

    def _written(self, t: float | None) -> Fields:
        """The fields that were written at the time nearest to ``t``."""
        return Fields(_undula.read_fields(self._entry(t)[1]))

    def _directory(self) -> str:
        if self.directory is None:
            raise _undula.InputError("the run has no files: give `run` a directory")
        return self.directory

    def report(self, to: str | os.PathLike[str] | None = None) -> str:
        """Writes the page of the run, ``report.html`` in its directory or ``to``, and returns its path."""
        return str(_undula.page(self._directory(), None if to is None else os.fspath(to)))

    def plot(self, to: str | os.PathLike[str] | None = None) -> list[str]:
        """Draws histories and last fields into ``plots`` in the directory, or ``to``, and returns the paths."""
        return [str(path) for path in _undula.plots(self._directory(), None if to is None else os.fspath(to))]


_alive: weakref.WeakSet[Run] = weakref.WeakSet()


@atexit.register
def _stop_all() -> None:
    """Runs that still wait write their last checkpoint."""
    for run in list(_alive):
        if not run.ended and run.directory is not None:
            run.stop()


class Run(_Results):
    """A run of a case; a loop over it computes one step after the other.

        run = undula.Case("fsi3").run("out/fsi3")
        for row in run:
            if row["uy_A"] > 0.03:
                run.stop()

    The interpreter is free while a step is computed. Ctrl-C ends the step: a run in memory keeps the state before it
    and can go on, one with files is interrupted as the program is and can be resumed. A loop that is left by ``break``
    can be entered again. ``with case.run("out") as run:`` ends the run at the end of the block.
    """

    def __init__(self, run: _undula.Run, case: Case, directory: str | None) -> None:
        self._run = run
        #: The case.
        self.case = case.copy()
        #: Where the files are; None without files.
        self.directory = directory
        self._columns = [*_FIRST, *run.names, *_LAST]
        self._at = {name: n for n, name in enumerate(self._columns)}
        self._values = [_flat(row) for row in run.rows]
        _alive.add(self)

    def __iter__(self) -> Run:
        return self

    def __next__(self) -> Row:
        row = self.step()
        if row is None:
            raise StopIteration
        return row

    def step(self) -> Row | None:
        """Computes the next step, or the stationary solution; None at the end.

        Raises :class:`Breakdown` if there is no solution; files are written as the program writes them.
        """
        numbers = self._run.step()
        if numbers is None:
            return None
        values = _flat(numbers)
        self._values.append(values)
        return Row(self._at, values)

    def finish(self, callback: Callable[[Row], object] | None = None, *, until: float | None = None) -> Run:
        """Computes all steps, or those up to the time ``until`` [s], and returns the run.

        ``callback`` is called with the row after every step, when :meth:`fields` and :meth:`at` have its state. If it
        returns True, no more steps are computed; :meth:`stop` ends the run for good.
        """
        while until is None or not self._values or self._values[-1][1] < until - 1e-9 * abs(until):
            row = self.step()
            if row is None or callback is not None and callback(row) is True:
                break
        return self

    def stop(self) -> None:
        """Ends the run. One with files writes its last fields, a checkpoint and its summary, and can be resumed."""
        self._run.stop()

    def __enter__(self) -> Run:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    @property
    def ended(self) -> bool:
        """Whether there are no more steps."""
        return self._run.ended

    @property
    def units(self) -> dict[str, str]:
        """SI units of the functionals."""
        return dict(zip(self._run.names, self._run.units))

    @property
    def notes(self) -> list[str]:
        """What should be known, such as settings without effect."""
        return self._run.notes

    @property
    def summary(self) -> dict[str, Any]:
        """Status, sizes, counts, times and the statistics of the functionals so far, as in ``summary.json``."""
        text = self._run.summary()
        if text is None:
            return json.loads(_read(os.path.join(self._directory(), "summary.json")))
        return json.loads(text)

    def fields(self, t: float | None = None) -> Fields:
        """The fields now, or those that were written into the directory at the time nearest to ``t`` [s].

        ``fields.time`` says which they are.
        """
        if t is not None and not (self._values and t == self._values[-1][1]):
            return self._written(t)
        now = self._run.fields()
        return self._written(t) if now is None else Fields(now)

    def at(self, point: Sequence[float]) -> dict[str, Any]:
        """The solution now at a position on the reference domain, two or three coordinates [m].

        ``velocity`` [m/s] and ``displacement`` [m] of the shape (d,), ``velocity_gradient`` [1/s] and
        ``displacement_gradient`` of the shape (d, d), whose [i, j] is the derivative of component i along x_j;
        ``pressure`` [Pa]; ``is_solid``.
        """
        found = self._run.at([float(x) for x in point])
        if found is None:
            return load(self._directory()).at(point)
        return _arrays(found)

    def _repr_png_(self) -> bytes | None:
        field = "velocity" if "fluid" in self.case else "deformation"
        title = f"{self.case.name},  t = {self._values[-1][1]:.6g} s" if self._values else self.case.name
        picture = self._run.picture(field, title)
        if picture is None and self._entries():
            picture = _undula.picture(self._entry(None)[1], field, title)
        return picture

    def __repr__(self) -> str:
        cells, unknowns, threads = self._run.sizes
        steps = len(self._values)
        return f"<undula.Run {self.case.name}: {cells} cells, {unknowns} unknowns, {threads} threads, {steps} rows>"


class Loaded(_Results):
    """What a run has left in its directory, see :func:`load`."""

    def __init__(self, directory: str) -> None:
        self.directory = directory
        #: ``summary.json``.
        self.summary: dict[str, Any] = json.loads(_read(os.path.join(directory, "summary.json")))
        lines = _read(os.path.join(directory, "history.csv")).split("\n")
        self._columns = lines[0].split(",")
        # The last line may be one that is just written.
        counts = [name in _COUNTS for name in self._columns]
        self._values = [
            tuple(int(x) if count else float(x) for x, count in zip(line.split(","), counts))
            for line in lines[1:-1]
        ]
        self._state: _undula.Run | None = None

    @property
    def case(self) -> Case:
        """The case, which can be changed and run anew."""
        from ._case import Case

        return Case(os.path.join(self._directory(), "case.toml"))

    @property
    def units(self) -> dict[str, str]:
        """SI units of the functionals."""
        return {name: of["unit"] for name, of in self.summary.get("functionals", {}).items()}

    def resume(self, *, threads: int | None = None, **settings: Any) -> Run:
        """Goes on from the last checkpoint, with the same bits as without the pause.

        Settings such as ``**{"time.end": 20}`` change the end, the output or the solvers.
        """
        return self.case.set(settings).run(self._directory(), threads=threads, resume=True)

    def fields(self, t: float | None = None) -> Fields:
        """The fields that were written at the time nearest to ``t`` [s], or last; ``fields.time`` says when."""
        return self._written(t)

    def at(self, point: Sequence[float]) -> dict[str, Any]:
        """The solution at the last checkpoint at a position on the reference domain, see :meth:`Run.at`."""
        if self._state is None:
            self._state = self.case._case.restore(self._directory(), os.cpu_count() or 1)
        found = self._state.at([float(x) for x in point])
        return _arrays(found or {})

    def _repr_png_(self) -> bytes | None:
        if not self._entries():
            return None
        time, path = self._entry(None)
        field = "velocity" if "fluid" in self.case else "deformation"
        return _undula.picture(path, field, f"{self.summary['case']},  t = {time:.6g} s")

    def __repr__(self) -> str:
        status = self.summary.get("status")
        return f"<undula.Loaded {self.directory}: {self.summary.get('case')}, {status}, {len(self._values)} rows>"


def load(directory: str | os.PathLike[str]) -> Loaded:
    """The run in ``directory``, computed by the program or from Python: history, summary, fields, case.

    Raises :class:`InputError` if there is none.
    """
    path = os.fspath(directory)
    missing = [name for name in ("case.toml", "history.csv", "summary.json") if not os.path.exists(os.path.join(path, name))]
    if missing:
        raise _undula.InputError(f"{path}: no {missing[0]}; expected the directory of a run")
    return Loaded(path)


def _flat(row: tuple[int, float, float, list[float], float, int, int]) -> tuple[Any, ...]:
    step, time, force_time, values, *last = row
    return (step, time, force_time, *values, *last)


def _arrays(found: dict[str, Any]) -> dict[str, Any]:
    return {name: np.array(value) if isinstance(value, list) else value for name, value in found.items()}


def _read(path: str) -> str:
    with open(path, encoding="utf-8") as file:
        return file.read()
