"""Study: one scene, many variants, what is compared and with what; as data, from TOML or from Python."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs

from myobridge.errors import ParameterError, SceneError, nearest
from myobridge.location import Origin
from myobridge.scene import Scene
from myobridge.study.norms import NORMS
from myobridge.study.quantities import Quantity
from myobridge.study.reference import Reference
from myobridge.study.variants import NUMERICAL, Variant, crossed, flattened

if TYPE_CHECKING:
    from myobridge.study.progress import Watch
    from myobridge.study.result import StudyResult

__all__ = ["Study"]


def _scene(value: Any) -> Scene:
    return value if isinstance(value, Scene) else Scene.load(value)


def _blocks(value: Any) -> tuple[Mapping[str, Any], ...]:
    blocks = [value] if isinstance(value, Mapping) else value
    if not isinstance(blocks, list | tuple) or not all(isinstance(block, Mapping) for block in blocks):
        raise ParameterError("vary", f"is {value!r}; expected a table of scene keys, or a list of such tables")
    return tuple(dict(block) for block in blocks)


def _quantities(value: Any) -> tuple[Quantity, ...]:
    if isinstance(value, str | Quantity):
        value = [value]
    if isinstance(value, Mapping):
        value = [Quantity(name, function) for name, function in value.items()]
    if not isinstance(value, list | tuple) or not all(isinstance(item, str | Quantity) for item in value):
        raise ParameterError("quantities", f"is {value!r}; expected a list of names")
    return tuple(map(Quantity.of, value))


def _norm(value: Any) -> str:
    if value not in NORMS:
        raise ParameterError("norm", f"is {value!r}. {nearest(str(value), NORMS)}")
    return value


def _positive(name: str) -> Callable[[Any], float | None]:
    def convert(value: Any) -> float | None:
        if value is None:
            return None
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < float("inf"):
            raise ParameterError(name, f"is {value!r}; expected a number in (0, inf)")
        return float(value)

    return convert


def _repeats(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise ParameterError("repeats", f"is {value!r}; expected a whole number in [1, inf)")
    return value


@attrs.frozen(kw_only=True)
class Study:
    """What is varied, what is compared, and with what.

    Parameters
    ----------
    scene : Scene or path
        With time; a path of equilibria has no steps to be priced.
    vary : mapping or sequence of mapping
        Scene keys, dotted as in ``--set``. A list is an axis, and axes are crossed; a table of tables is an axis whose
        values have names and set several keys; anything else is set in every variant. Several blocks are added up.
        ``family`` names the line of the plot, ``model`` the equations, where the usual names will not do.
    quantities : sequence of str or Quantity, or mapping from names to functions
        What is compared; tension and tip without.
    norm : {"max", "rms", "end"}
        Norm in time, see `myobridge.study.norms`.
    tolerance : float, optional
        Relative error that is good enough: with it there is a recommendation.
    repeats : int
        Timed runs of each variant; medians count.
    at : sequence of float
        Times at which all steps end [s].
    numerical : sequence of str
        Patterns of keys that change how well the equations are solved; any other key makes another model.
    reference : Reference or mapping
    search : bool
        Run the cheapest variants first, and leave out those that cannot win.
    settings : mapping
        Keys set on top of the scene, in all runs.
    name : str

    Raises
    ------
    MyobridgeError
        One clear message: which key, what is wrong, what is allowed.

    Examples
    --------
    >>> import myobridge as mb
    >>> study = mb.Study(
    ...     scene="examples/ramp.toml", vary={"scene.step": [4e-3, 2e-3]}, tolerance=1e-2
    ... )  # doctest: +SKIP
    >>> result = study.run(workers=0)  # doctest: +SKIP
    >>> result.recommend(1e-2).command  # doctest: +SKIP
    '--set scene.step=0.002'
    """

    scene: Scene = attrs.field(converter=_scene)
    vary: tuple[Mapping[str, Any], ...] = attrs.field(converter=_blocks)
    quantities: tuple[Quantity, ...] = attrs.field(default=(), converter=_quantities)
    norm: str = attrs.field(default="max", converter=_norm)
    tolerance: float | None = attrs.field(default=None, converter=_positive("tolerance"))
    repeats: int = attrs.field(default=3, converter=_repeats)
    at: tuple[float, ...] = attrs.field(default=(), converter=tuple)
    numerical: tuple[str, ...] = attrs.field(default=NUMERICAL, converter=tuple)
    reference: Reference = attrs.field(factory=Reference, converter=Reference.of)
    search: bool = False
    settings: Mapping[str, Any] = attrs.field(factory=dict, converter=flattened)
    name: str = ""
    variants: tuple[Variant, ...] = attrs.field(init=False, repr=False)

    @variants.default  # pyright: ignore[reportAttributeAccessIssue]
    def _variants(self) -> tuple[Variant, ...]:
        return crossed(self.vary, self.numerical)

    def __attrs_post_init__(self) -> None:
        from myobridge.study.checks import check

        check(self)

    @property
    def title(self) -> str:
        """Name of the study, or that of its scene."""
        return self.name or self.scene.name

    def scene_of(self, settings: Mapping[str, Any]) -> Scene:
        """Scene of the study with keys set on top."""
        return self.scene.with_settings({**self.settings, **settings})

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Study:
        """Read a study from a TOML file: ``[study]``, ``[settings]``, ``[vary]`` and ``[reference]``.

        Raises
        ------
        SceneError
            With file, line and key, what is allowed and the nearest match.
        """
        source = Path(path)
        try:
            written = source.read_text(encoding="utf-8-sig")
            data = tomllib.loads(written)
        except OSError as error:
            raise SceneError(f"{source}: cannot be read ({error.strerror})") from None
        except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
            raise SceneError(f"{source}: is not valid TOML: {error}") from None
        origin = Origin(str(source), written)
        try:
            return cls.from_data(data, source.parent)
        except ParameterError as error:
            key = f"study.{error.key}" if error.key.split(".")[0].split("[")[0] in _HEAD else error.key
            raise SceneError(f"{origin.of(key)}{key}: {error.problem}") from None

    @classmethod
    def from_data(cls, data: Mapping[str, Any], folder: Path) -> Study:
        """Study from plain nested data; `folder` is where its scene is looked for."""
        for key in data:
            if key not in ("study", *_TABLES):
                raise ParameterError(key, f"is no section of a study. {nearest(key, ('study', *_TABLES))}")
        head = dict(data.get("study", {}))
        for key in head:
            if key not in _HEAD:
                raise ParameterError(f"study.{key}", f"is unknown. {nearest(key, _HEAD)}")
        scene = head.pop("scene", None)
        if not isinstance(scene, str):
            raise ParameterError("scene", f"is {scene!r}; expected the file of a scene, relative to that of the study")
        tables = {key: data[key] for key in _TABLES if key in data}
        return cls(**{"vary": (), **head, **tables}, scene=Scene.load(folder / scene))

    def run(
        self,
        folder: str | os.PathLike[str] | None = None,
        *,
        workers: int | None = None,
        scheduler: str | None = None,
        watch: Watch | None = None,
    ) -> StudyResult:
        """Run all variants and the reference.

        Parameters
        ----------
        folder : path, optional
            Where finished runs are kept, each under a hash of all that it depends on; a study that was killed or has
            been extended goes on from there. Without, nothing is written.
        workers : int, optional
            Processes of a local dask cluster; one a core without. 0: in this process. Processes are spawned, so a
            script that runs a study stands under ``if __name__ == "__main__":``.
        scheduler : str, optional
            Address of a dask scheduler that is running; its workers must have the same versions installed.
        watch : callable, optional
            Told what is finished, see `myobridge.study.progress`.

        Raises
        ------
        MyobridgeError
            If the scheduler is not reached, or the folder cannot be written to; what is finished is kept.
        KeyboardInterrupt
            When interrupted; what is finished is kept.
        """
        from myobridge.study.running import run

        return run(self, folder, workers=workers, scheduler=scheduler, watch=watch)


_HEAD = ("name", "scene", "quantities", "norm", "tolerance", "repeats", "at", "numerical", "search")
_TABLES = ("settings", "vary", "reference")
