"""One run of a study: an order on standard input, its results on standard output, both JSON."""

from __future__ import annotations

import json
import sys
from typing import Any

from . import _undula
from ._case import Case


def compute(order: dict[str, Any]) -> dict[str, Any]:
    """The results of the run that ``order`` describes; "error" if it has gone wrong."""
    case = Case(order["source"])
    case._text, case._settings = order["text"], order["settings"]
    answer: dict[str, Any] = {}
    try:
        run = case.run(order["directory"], threads=order["threads"])
    except (_undula.InputError, OSError, RuntimeError) as error:
        return {"error": str(error)}
    try:
        run.finish()
    except (_undula.Breakdown, OSError, RuntimeError) as error:
        answer["error"] = str(error)
    answer["summary"] = run.summary
    answer["history"] = {name: values.tolist() for name, values in run.history.items()}
    return answer


if __name__ == "__main__":
    json.dump(compute(json.load(sys.stdin)), sys.stdout)
