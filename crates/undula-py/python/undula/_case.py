"""Cases: what is computed."""

from __future__ import annotations

import base64
import html
import os
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Union

from . import _undula
from ._run import Run

#: What a key of a case may be set to: a number, a word or an expression, a list of them, a function of time [s], or
#: None, which removes the key or the table.
Value = Union[None, bool, int, float, str, "os.PathLike[str]", Callable[[float], float], "list[Value]", Any]


def cases() -> list[str]:
    """Names of the built-in cases."""
    return _undula.builtin()


def keys(pattern: str = "") -> str:
    """Keys of a case with units, default values and meanings, as ``undula keys`` prints them."""
    return _undula.keys(pattern)


class Case:
    """A case: a built-in one, a file, TOML text, or a dictionary of keys.

    ``Case("fsi3")``, ``Case("own.toml")``, ``Case("name = 'own'\\n[mesh]\\n...")``, ``Case({"name": "own", "mesh":
    {"generator": "box", ...}})``. Keys are set by ``case["fluid.density"] = 900``; nothing is checked before the case is
    used, which tells all mistakes at once as an :class:`InputError`. Numbers are in SI units, or texts with a unit such
    as ``"120 mmHg"``.
    """

    def __init__(self, source: str | os.PathLike[str] | Mapping[str, Any], **settings: Value) -> None:
        self._source: str = "case"
        self._text: str | None = None
        self._settings: list[str] = []
        self._functions: dict[str, tuple[Callable[[float], float], Callable[[float], float] | None]] = {}
        self._checked: _undula.Case | None = None
        if isinstance(source, Mapping):
            self._text = ""
            for key, value in _leaves(source):
                self._set(key, value)
        elif isinstance(source, str) and ("\n" in source or "=" in source):
            self._text = source
        else:
            self._source = os.fspath(source)
        for key, value in settings.items():
            self._set(key, value)

    # What it says ---------------------------------------------------------------------------------------------------

    def __setitem__(self, key: str, value: Value) -> None:
        self._set(key, value)

    def __delitem__(self, key: str) -> None:
        self._set(key, None)

    def __getitem__(self, key: str) -> Any:
        """The value of the dotted ``key`` with all defaults, a dictionary for a table."""
        found: Any = self._case.data()
        for part in _parts(key):
            if not isinstance(found, Mapping) or part not in found:
                raise KeyError(key)
            found = found[part]
        return found

    def __contains__(self, key: str) -> bool:
        try:
            self[key]
        except KeyError:
            return False
        return True

    def set(self, key: str | Mapping[str, Any], value: Value = None) -> Case:
        """Sets a dotted key, or all keys of a dictionary, and returns the case.

        The value None removes the key or the table, such as ``case.set("solid", None)`` for a rigid body.
        """
        if isinstance(key, Mapping):
            for leaf, of in _leaves(key):
                self._set(leaf, of)
        else:
            self._set(key, value)
        return self

    def function(
        self, name: str, function: Callable[[float], float], slope: Callable[[float], float] | None = None
    ) -> Case:
        """Lets expressions call ``function``, a function of one number, as ``table("name", t)``.

        It is called at every time at which the scheme needs it, not interpolated. ``slope`` is its derivative, which
        prescribed displacements need for the velocity; without it a central difference with a step of 1e-6 max(1, |t|)
        is taken. An exception that it raises ends the run and is raised there.

            case.function("pulse", lambda t: math.sin(t) ** 2)
            case["boundary.inflow.velocity"] = ['1.5*4*y*(0.41 - y)/0.41^2 * table("pulse", t)', "0"]
        """
        self._checked = None
        self._functions[name] = (function, slope)
        return self

    def copy(self) -> Case:
        """An independent copy."""
        other = Case.__new__(Case)
        other._source, other._text = self._source, self._text
        other._settings, other._functions = list(self._settings), dict(self._functions)
        other._checked = self._checked
        return other

    def _set(self, key: str, value: Value) -> None:
        self._checked = None
        self._settings.append(f"{key}={self._toml(key, value)}")

    def _toml(self, key: str, value: Value) -> str:
        if callable(value):
            name = f"{key} {len(self._functions)}"
            self._functions[name] = (value, None)
            return _text(f"table('{name}', t)")
        if isinstance(value, (list, tuple)) or hasattr(value, "tolist") and getattr(value, "ndim", 0) > 0:
            items = value if isinstance(value, (list, tuple)) else value.tolist()
            return "[" + ", ".join(self._toml(key, item) for item in items) + "]"
        if isinstance(value, Mapping):
            return "{" + ", ".join(f"{k} = {self._toml(f'{key}.{k}', v)}" for k, v in value.items()) + "}"
        return _literal(value)

    @property
    def _case(self) -> _undula.Case:
        if self._checked is None:
            functions = [(name, f, slope) for name, (f, slope) in self._functions.items()]
            self._checked = _undula.Case(self._source, self._text, self._settings, functions)
        return self._checked

    @property
    def name(self) -> str:
        """Short name."""
        return self._case.name

    @property
    def title(self) -> str:
        """What it is, in a line."""
        return self._case.title

    @property
    def toml(self) -> str:
        """The case as TOML with all defaults and comments, as ``undula check --toml`` prints it."""
        return self._case.toml()

    @property
    def notes(self) -> list[str]:
        """What should be known, such as settings without effect."""
        return self._case.notes

    def check(self) -> str:
        """Mesh, unknowns, Reynolds and CFL number in words, as ``undula check`` prints them; nothing is computed.

        Raises :class:`InputError` if the case is wrong or does not fit its mesh.
        """
        return self._case.summary()

    # What is done with it -------------------------------------------------------------------------------------------

    def run(
        self,
        directory: str | os.PathLike[str] | None = None,
        *,
        threads: int | None = None,
        force: bool = False,
        resume: bool = False,
    ) -> Run:
        """A run, whose steps are computed one by one by a loop over it, or all by :meth:`Run.finish`.

        Without ``directory`` nothing is written. With it the files are those of ``undula run``; ``force`` replaces a run
        that is there, ``resume`` goes on from its last checkpoint with the same bits. ``threads`` is the number of
        threads, by default all cores; the results do not depend on it.
        """
        count = os.cpu_count() or 1 if threads is None else threads
        path = None if directory is None else os.fspath(directory)
        if path is None and resume:
            raise _undula.InputError("resume: expected the directory of a run")
        return Run(self._case.start(path, count, force, resume), self, path)

    def _repr_png_(self) -> bytes | None:
        """A picture of the domain and its mesh at the start."""
        return _picture_of(self)

    def _repr_html_(self) -> str:
        picture = _picture_of(self)
        image = ""
        if picture:
            image = f'<img style="max-width:100%" src="data:image/png;base64,{base64.b64encode(picture).decode()}">'
        return f"{image}<pre>{html.escape(self.check())}</pre>"

    def __repr__(self) -> str:
        return f"<undula.Case {self.name}: {self.title}>"


#: Cells up to which a case in a notebook is drawn.
_DRAWN = 50_000


def _picture_of(case: Case) -> bytes | None:
    run = case._case.preview()
    if run.sizes[0] > _DRAWN:
        return None
    field = "velocity" if "fluid" in case else "deformation"
    return run.picture(field, f"{case.name}: {case.title}")


def _leaves(table: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    """Dotted keys with their values; keys of the table may be dotted, too."""
    for key, value in table.items():
        plain = all(part.replace("-", "").replace("_", "").isalnum() for part in key.split(".")) or key[:1] in "\"'"
        path = before + (key if plain else _text(key))
        if isinstance(value, Mapping) and value:
            yield from _leaves(value, path + ".")
        else:
            yield path, value


def _parts(key: str) -> list[str]:
    """The parts of a dotted key; those in quotes may have dots."""
    parts, inside, part = [], "", ""
    for letter in key:
        if inside:
            if letter == inside:
                inside = ""
            else:
                part += letter
        elif letter in "\"'":
            inside = letter
        elif letter == ".":
            parts.append(part)
            part = ""
        else:
            part += letter
    return [*parts, part]


def _text(text: str) -> str:
    """A text of TOML."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    escaped = escaped.replace("\n", "\\n").replace("\t", "\\t").replace("\r", "\\r")
    return f'"{escaped}"'


def _literal(value: Any) -> str:
    """A number, a word or a truth value of TOML."""
    if value is None:
        return "none"
    if isinstance(value, os.PathLike):
        return _text(os.fspath(value))
    if isinstance(value, str):
        return _text(value)
    if hasattr(value, "item"):
        value = value.item()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        text = repr(value)
        return text if any(mark in text for mark in ".en") else text + ".0"
    raise TypeError(f"expected a number, a text, a list, a function of time or None, not {type(value).__name__}")
