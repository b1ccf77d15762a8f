"""The errors a user meets: each says what was wrong, where, what is allowed, and the nearest match."""

from __future__ import annotations

import contextlib
import difflib
from collections.abc import Iterable, Iterator
from typing import Any

__all__ = [
    "ContinuationFailed",
    "MyobridgeError",
    "ParameterError",
    "PluginError",
    "SceneError",
    "StepFailed",
    "nearest",
    "within",
]


class MyobridgeError(Exception):
    """Any error that is the user's to mend; the command line prints it without a traceback."""


class PluginError(MyobridgeError):
    """A plugin is unknown, clashes with another, or breaks its contract."""


class SceneError(MyobridgeError):
    """A scene says something that cannot be simulated."""


class StepFailed(MyobridgeError):
    """A step failed although it was halved as often as allowed; what was computed before is kept."""


class ContinuationFailed(MyobridgeError):
    """A path of equilibria ended early; `result` holds what was found before, None where there is nothing."""

    result: Any = None


class ParameterError(MyobridgeError):
    """A parameter has a wrong name, type or range.

    Parameters
    ----------
    key : str
        The parameter, dotted from the plugin inwards (``rates.f1``).
    problem : str
        What is wrong and what is allowed.
    """

    def __init__(self, key: str, problem: str) -> None:
        super().__init__(f"{key}: {problem}")
        self.key = key
        self.problem = problem


@contextlib.contextmanager
def within(key: str) -> Iterator[None]:
    """Errors of a part, told with the key under which the part stands: ``file`` becomes ``mesh.file``."""
    try:
        yield
    except ParameterError as error:
        raise ParameterError(f"{key}.{error.key}", error.problem) from None


def nearest(word: str, allowed: Iterable[str]) -> str:
    """Sentence that lists what is allowed and, when one is close to `word`, suggests it."""
    names = sorted(allowed)
    sentence = f"Allowed: {', '.join(names)}." if names else "Nothing is allowed here."
    close = difflib.get_close_matches(word, names, n=1, cutoff=0.6)
    return f"{sentence} Did you mean '{close[0]}'?" if close else sentence
