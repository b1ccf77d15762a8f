"""Store: finished runs on disk, each under a hash of all that it depends on."""

from __future__ import annotations

import hashlib
import inspect
import json
import os
import zipfile
from collections.abc import Iterator
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any, final

import attrs
import numpy as np

from myobridge.errors import MyobridgeError
from myobridge.study.measurement import Course, Measurement, Task

__all__ = ["Store", "key_of"]

_PACKAGES = ("numpy", "scipy", "numba")


@final
class Store:
    """Folder of finished runs; without one they are kept in memory.

    Raises
    ------
    MyobridgeError
        If the folder cannot be made.
    """

    NAME = "runs"

    def __init__(self, folder: str | os.PathLike[str] | None) -> None:
        self.folder = None if folder is None else Path(folder) / self.NAME
        self._known: dict[str, Measurement] = {}
        if self.folder is not None:
            try:
                self.folder.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise MyobridgeError(f"{self.folder}: cannot be made ({error.strerror})") from None

    def find(self, key: str) -> Measurement | None:
        """The run of that key; None where it is not there, or damaged."""
        if key not in self._known and self.folder is not None:
            found = _read(self.folder / f"{key}.npz")
            if found is not None:
                self._known[key] = found
        return self._known.get(key)

    def keep(self, key: str, measurement: Measurement) -> None:
        """Write a run at once, beside its name first: a file of that name is always whole.

        Raises
        ------
        MyobridgeError
            If it cannot be written, say because the disk is full; what was written before is still there.
        """
        self._known[key] = measurement
        if self.folder is None:
            return
        target = self.folder / f"{key}.npz"
        beside = target.with_name(f"{key}.part")
        try:
            _write(beside, measurement)
            os.replace(beside, target)
        except OSError as error:
            beside.unlink(missing_ok=True)
            kept = len(list(self.folder.glob("*.npz")))
            raise MyobridgeError(
                f"{target}: cannot be written ({error.strerror or error}); {kept} finished runs are kept "
                "there, and the same command goes on from them"
            ) from None


def key_of(task: Task, number: int) -> str:
    """Hash of what run `number` of a task depends on: scene, files, quantities, installed sources, packages."""
    from myobridge.atlas.cell import sources_digest

    said = [
        task.scene,
        dict(_files(task)),
        [[quantity.name, _source(quantity.function)] for quantity in task.quantities],
        [list(task.stops), task.optional],
        number,
        sources_digest(),
        _versions(),
    ]
    return hashlib.sha256(json.dumps(said).encode()).hexdigest()[:24]


@cache
def _versions() -> dict[str, str]:
    return {name: metadata.version(name) for name in _PACKAGES}


def _files(task: Task) -> Iterator[tuple[str, str]]:
    """Digests of the files that a scene names: a mesh may change under the same name."""
    import tomllib

    def words(value: Any) -> Iterator[str]:
        if isinstance(value, str):
            yield value
        elif isinstance(value, dict | list):
            for item in value.values() if isinstance(value, dict) else value:
                yield from words(item)

    for word in sorted(set(words(tomllib.loads(task.scene)))):
        path = Path(task.folder) / word
        try:
            if "." in word and path.is_file():
                yield word, hashlib.sha256(path.read_bytes()).hexdigest()
        except OSError:  # a word that is no file name
            continue


def _source(function: Any) -> str:
    """What a function of the user's does, as text; its closure too, as far as it can be printed."""
    if function is None:
        return ""
    try:
        text = inspect.getsource(function)
    except (OSError, TypeError):
        code = getattr(function, "__code__", None)
        text = repr(function) if code is None else code.co_code.hex() + repr(code.co_consts)
    cells = [cell.cell_contents for cell in getattr(function, "__closure__", None) or ()]
    return f"{text}{cells!r}"


_PLAIN = tuple(field.name for field in attrs.fields(Measurement) if field.name != "course")


def _write(path: Path, measurement: Measurement) -> None:
    plain: Any = {name: getattr(measurement, name) for name in _PLAIN}
    arrays = {"said": np.array(json.dumps(plain))}
    if measurement.course is not None:
        arrays["times"] = measurement.course.times
        arrays |= {f"values/{name}": values for name, values in measurement.course.values.items()}
    with path.open("wb") as file:
        np.savez(file, **arrays)  # pyright: ignore[reportArgumentType]


def _read(path: Path) -> Measurement | None:
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as found:
            plain = json.loads(str(found["said"]))
            course = None
            if "times" in found:
                values = {
                    name.removeprefix("values/"): found[name] for name in found.files if name.startswith("values/")
                }
                course = Course(found["times"], values)
            return Measurement(**plain, course=course)
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile):
        return None
