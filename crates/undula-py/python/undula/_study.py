"""Many runs of a case, side by side in processes of their own."""

from __future__ import annotations

import itertools
import json
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from . import _undula
from ._case import Case
from ._run import _COUNTS


class StudyRun:
    """One run of a study."""

    def __init__(self, settings: dict[str, Any], answer: dict[str, Any]) -> None:
        #: The keys and values of this run.
        self.settings = settings
        #: What has gone wrong, in words; None if nothing has.
        self.error: str | None = answer.get("error")
        #: As :attr:`Run.summary`; empty if there was no run.
        self.summary: dict[str, Any] = answer.get("summary") or {}
        #: As :attr:`Run.history`.
        self.history: dict[str, np.ndarray] = {
            name: np.array(values, dtype=np.int64 if name in _COUNTS else float)
            for name, values in answer.get("history", {}).items()
        }

    def __getitem__(self, name: str) -> float:
        """The last value of the functional or column ``name``."""
        return self.history[name][-1].item()

    def __repr__(self) -> str:
        what = self.error or f"{len(next(iter(self.history.values()), []))} rows"
        return f"<undula.StudyRun {self.settings}: {what}>"


class Study(Sequence[StudyRun]):
    """The runs of a study in the order of the product of the values, the last key changing fastest."""

    def __init__(self, runs: list[StudyRun]) -> None:
        self._runs = runs

    def __getitem__(self, at: Any) -> Any:
        return self._runs[at]

    def __len__(self) -> int:
        return len(self._runs)

    def __iter__(self) -> Iterator[StudyRun]:
        return iter(self._runs)

    def to_pandas(self) -> Any:
        """A ``pandas.DataFrame`` with a row per run: its settings, and the last values of all columns."""
        import pandas

        rows = []
        for run in self._runs:
            last = {name: values[-1] for name, values in run.history.items() if len(values)}
            rows.append({**run.settings, **last, "error": run.error})
        return pandas.DataFrame(rows)


def study(
    base: Case | str | os.PathLike[str] | Mapping[str, Any],
    over: Mapping[str, Sequence[Any]],
    *,
    directory: str | os.PathLike[str] | None = None,
    processes: int | None = None,
    threads: int = 1,
) -> Study:
    """Runs ``base`` with all combinations of the values of ``over``, side by side.

        undula.study("csm1", over={"solid.mu": [0.5e6, 1e6], "mesh.refine": [0, 1]})

    Every run has a process of its own with ``threads`` threads; ``processes`` run at a time, by default as many as the
    cores allow. With a ``directory`` each run leaves its files in ``directory/0``, ``directory/1``, ... A run that goes
    wrong has its message in :attr:`StudyRun.error`; the others go on. Functions of Python cannot be sent to other
    processes and are refused.
    """
    case = base if isinstance(base, Case) else Case(base)
    if case._functions:
        raise _undula.InputError("a study has no functions of Python: they cannot be sent to other processes")
    points = [dict(zip(over, values)) for values in itertools.product(*over.values())]
    for settings in points:
        # Mistakes are told before anything is computed.
        case.copy().set(settings)._case  # noqa: B018
    if processes is None:
        processes = max(1, (os.cpu_count() or 1) // max(1, threads))

    def compute(number: int) -> StudyRun:
        settings = points[number]
        own = case.copy().set(settings)
        place = None if directory is None else os.path.join(os.fspath(directory), str(number))
        order = {
            "source": own._source, "text": own._text, "settings": own._settings, "directory": place, "threads": threads,
        }
        done = subprocess.run(
            [sys.executable, "-m", "undula._worker"], input=json.dumps(order), capture_output=True, text=True, check=False
        )
        if done.returncode != 0:
            return StudyRun(settings, {"error": f"the process has ended with {done.returncode}: {done.stderr.strip()}"})
        return StudyRun(settings, json.loads(done.stdout))

    with ThreadPoolExecutor(max_workers=processes) as pool:
        return Study(list(pool.map(compute, range(len(points)))))
