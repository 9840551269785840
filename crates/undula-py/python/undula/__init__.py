"""Elastic bodies in incompressible flow, solved as one nonlinear system in ALE coordinates.

    import undula
    case = undula.Case("csm3").set("time.end", 0.1)
    for row in case.run():
        print(row.time, row["uy_A"])

All numbers are in SI units. Arrays are numpy arrays. A case is a built-in case, a file, TOML text or a dictionary; its
keys are those of `undula keys` (:func:`keys`). The numbers are those of the program `undula`, bit for bit.
"""

from __future__ import annotations

from . import _undula
from ._case import Case, cases, keys
from ._fields import Fields
from ._mesh import write_mesh
from ._run import Row, Run, load
from ._study import Study, StudyRun, study
from ._undula import Breakdown, InputError

__all__ = [
    "Breakdown", "Case", "Fields", "InputError", "Row", "Run", "Study", "StudyRun", "cases", "keys", "load", "study",
    "write_mesh",
]

__version__: str = _undula.version()


def _command() -> int:
    """The program ``undula`` with the arguments of the process."""
    import sys

    return _undula.command(["undula", *sys.argv[1:]])
