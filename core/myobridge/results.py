"""Results: one HDF5 file that opens while the run goes on, after a kill, and to continue from.

Layout: ``/series`` (one row a recorded step, one column a site), ``/density`` (snapshots), ``/scene`` (the TOML),
``/sites`` (numbers of its columns), ``/provenance`` (versions, plugins), ``/checkpoint`` (everything that the next step
depends on). The fields of a body are in ``/VTKHDF``, so that the same file opens in ParaView.
"""

from __future__ import annotations

import os
import platform
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from myobridge.bus import BusState
from myobridge.errors import MyobridgeError, nearest
from myobridge.fields import FieldSnapshot
from myobridge.interfaces import Array, Motion, VisibleMesh
from myobridge.ledger import Ledger
from myobridge.recording import DensitySnapshot
from myobridge.simulation import Simulation
from myobridge.step_control import StepControl
from myobridge.vtkhdf import read_body, write_body

__all__ = ["Checkpoint", "Result", "check_writable", "provenance"]


@attrs.frozen(eq=False)
class Checkpoint:
    """Everything that the next step depends on, by name."""

    scalars: Mapping[str, float]
    arrays: Mapping[str, Array]

    @classmethod
    def take(cls, simulation: Simulation) -> Checkpoint:
        """Copy the state of a simulation."""
        control = simulation.control
        scalars: dict[str, float] = {
            "time": simulation.time,
            "steps": simulation.steps,
            "iterations": simulation.iterations,
            "dt": control.dt,
            "halvings": control.halvings,
            "successes": control.successes,
        }
        error = simulation.step_error
        if error is not None:
            scalars |= {f"error/{name}": value for name, value in error.scalars().items()}
        scalars |= {f"ledger/{name}": value for name, value in simulation.ledger.as_dict().items()}
        motion = attrs.asdict(simulation.motion)
        arrays = {f"motion/{name}": np.array(value) for name, value in motion.items()}
        arrays |= {f"memory/{name}": np.array(value) for name, value in simulation.memory.items()}
        if error is not None:
            arrays["error/velocity"] = np.array(error.velocity)
        if simulation.bus is not None:
            arrays |= {f"bus/{name}": value for name, value in attrs.asdict(simulation.bus.state()).items()}
        return cls(scalars, arrays)

    def restore(self, simulation: Simulation) -> None:
        """Put a simulation of the same parts into this state.

        Raises
        ------
        MyobridgeError
            If it is the state of another simulation.
        """
        try:
            self._restore(simulation, dict(self.scalars))
        except (KeyError, TypeError, ValueError) as error:
            raise MyobridgeError(
                f"the checkpoint does not fit the simulation ({error}); was it written by another version?"
            ) from None

    def _restore(self, simulation: Simulation, scalars: Mapping[str, float]) -> None:
        motion = Motion(**_group(self.arrays, "motion/"))
        _same_shape("motion/displacement", motion.displacement, simulation.motion.displacement)
        if simulation.bus is not None:
            state = BusState(**_group(self.arrays, "bus/"))
            _same_shape("bus/population", state.population, simulation.bus.population)
            simulation.bus.restore(state)
        simulation.motion = motion
        simulation.memory = _group(self.arrays, "memory/")
        simulation.time = float(scalars["time"])
        simulation.steps = int(scalars["steps"])
        simulation.iterations = int(scalars["iterations"])
        simulation.control = StepControl(float(scalars["dt"]), int(scalars["halvings"]), int(scalars["successes"]))
        error = simulation.step_error
        if error is not None and "error/velocity" in self.arrays:
            error.estimate, error.dt = float(scalars["error/estimate"]), float(scalars["error/dt"])
            error.velocity = np.array(self.arrays["error/velocity"])
        simulation.ledger = Ledger(**_group(scalars, "ledger/"))


def _same_shape(name: str, found: Array, expected: Array) -> None:
    if found.shape != expected.shape:
        raise ValueError(f"{name} has shape {found.shape}, expected {expected.shape}")


def _group(items: Mapping[str, Any], prefix: str) -> dict[str, Any]:
    return {name.removeprefix(prefix): value for name, value in items.items() if name.startswith(prefix)}


def provenance(plugins: Mapping[str, str]) -> dict[str, str]:
    """Versions of what computed a result, and the plugins chosen."""
    packages = ("myobridge", "numpy", "scipy", "numba", "h5py")
    found = {f"version {name}": metadata.version(name) for name in packages}
    found |= {"python": platform.python_version(), "machine": platform.machine()}
    return found | {f"plugin {name}": value for name, value in plugins.items()}


@attrs.frozen(eq=False)
class Result:
    """What a run left: series, density snapshots, scene, provenance, checkpoint, and the fields of a body.

    Attributes
    ----------
    mesh : VisibleMesh or None
        Undeformed body; None for a solid without a shape.
    fields : tuple of FieldSnapshot
        Its kept states: ``result.fields[-1]["tension"]``.

    Examples
    --------
    >>> result = Result.load("quick_release.h5")  # doctest: +SKIP
    >>> result["time"], result["tension"], result["energy/external"]  # doctest: +SKIP
    """

    series: Mapping[str, Array]
    densities: tuple[DensitySnapshot, ...]
    scene: str
    provenance: Mapping[str, str]
    checkpoint: Checkpoint
    sites: Array
    mesh: VisibleMesh | None = None
    fields: tuple[FieldSnapshot, ...] = ()

    def __getitem__(self, name: str) -> Array:
        if name not in self.series:
            raise MyobridgeError(f"the result has no series '{name}'. {nearest(name, self.series)}")
        return self.series[name]

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write beside, then rename: whatever happens meanwhile, `path` is always a complete file."""
        target = Path(path)
        beside = _beside(target)
        try:
            self._write(beside)
            os.replace(beside, target)
        except OSError as error:
            beside.unlink(missing_ok=True)
            raise MyobridgeError(f"{target}: cannot be written ({error})") from None
        return target

    def _write(self, path: Path) -> None:
        import h5py

        with h5py.File(path, "w") as file:
            for name, rows in self.series.items():
                file[f"series/{name}"] = rows
            file["sites"] = self.sites  # no attribute: HDF5 limits those to 64 kB
            for number, snapshot in enumerate(self.densities):
                group = file.create_group(f"density/{number:04d}")
                group.attrs["time"] = snapshot.time
                group["position"] = snapshot.position
                group["fraction"] = snapshot.fraction
            if self.mesh is not None:
                write_body(file, self.mesh, self.fields)
            file["scene"] = self.scene
            file.create_group("provenance").attrs.update(self.provenance)
            checkpoint = file.create_group("checkpoint")
            checkpoint.attrs.update(self.checkpoint.scalars)
            for name, array in self.checkpoint.arrays.items():
                checkpoint[name] = array

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Result:
        """Read a result file.

        Raises
        ------
        MyobridgeError
            If there is no such file, or it is no result.
        """
        import h5py

        source = Path(path)
        if not source.is_file():
            raise MyobridgeError(f"{source}: there is no such file")
        try:
            with h5py.File(source, "r") as opened:
                file: Any = opened
                series: dict[str, Array] = {}
                arrays: dict[str, Array] = {}
                _visit(file["series"], series)
                _visit(file["checkpoint"], arrays)
                snapshots = tuple(
                    DensitySnapshot(float(group.attrs["time"]), group["position"][...], group["fraction"][...])
                    for group in (file["density"].values() if "density" in file else ())
                )
                return cls(
                    series,
                    snapshots,
                    file["scene"].asstr()[()],
                    {name: str(value) for name, value in file["provenance"].attrs.items()},
                    Checkpoint({name: value.item() for name, value in file["checkpoint"].attrs.items()}, arrays),
                    file["sites"][...],
                    *read_body(file),
                )
        except Exception as error:  # a damaged or a stranger's file may raise anything
            raise MyobridgeError(
                f"{source}: is damaged, or no result of myobridge ({type(error).__name__}: {error})"
            ) from None


def check_writable(path: str | os.PathLike[str]) -> Path:
    """The path of a result file yet to come.

    Raises
    ------
    MyobridgeError
        If nothing can be written there, or something that is no result would be overwritten.
    """
    import h5py

    target = Path(path)
    if target.is_dir():
        raise MyobridgeError(f"{target}: is a folder; name a file in it")
    if not target.parent.is_dir():
        raise MyobridgeError(f"{target}: cannot be written, there is no folder {target.parent}")
    if target.exists() and not h5py.is_hdf5(target):
        raise MyobridgeError(f"{target}: exists and is no result file; it is not overwritten")
    try:
        _beside(target).touch()
        _beside(target).unlink()
    except OSError as error:
        raise MyobridgeError(f"{target}: cannot be written ({error.strerror})") from None
    return target


def _beside(target: Path) -> Path:
    return target.with_name(target.name + ".part")


def _visit(group: Any, into: dict[str, Array]) -> None:
    import h5py

    def keep(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset):
            into[name] = item[...]

    group.visititems(keep)
