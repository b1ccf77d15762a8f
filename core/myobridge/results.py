"""Results: one HDF5 file that opens while the run goes on, after a kill, and to continue from.

Layout: ``/series`` (one row a recorded step, one column a site), ``/density`` (snapshots), ``/scene`` (the TOML),
``/provenance`` (versions, plugins), ``/checkpoint`` (everything that the next step depends on).
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
from myobridge.interfaces import Array, Motion
from myobridge.ledger import Ledger
from myobridge.recording import DensitySnapshot
from myobridge.simulation import Simulation
from myobridge.step_control import StepControl

__all__ = ["Checkpoint", "Result", "provenance"]


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
        scalars |= {f"ledger/{name}": value for name, value in simulation.ledger.as_dict().items()}
        motion = attrs.asdict(simulation.motion)
        arrays = {f"motion/{name}": np.array(value) for name, value in motion.items()}
        arrays |= {f"memory/{name}": np.array(value) for name, value in simulation.memory.items()}
        if simulation.bus is not None:
            arrays |= {f"bus/{name}": value for name, value in attrs.asdict(simulation.bus.state()).items()}
        return cls(scalars, arrays)

    def restore(self, simulation: Simulation) -> None:
        """Put a simulation of the same parts into this state."""
        scalars = dict(self.scalars)
        simulation.time = float(scalars["time"])
        simulation.steps = int(scalars["steps"])
        simulation.iterations = int(scalars["iterations"])
        simulation.control = StepControl(float(scalars["dt"]), int(scalars["halvings"]), int(scalars["successes"]))
        simulation.ledger = Ledger(**_group(scalars, "ledger/"))
        simulation.motion = Motion(**_group(self.arrays, "motion/"))
        simulation.memory = _group(self.arrays, "memory/")
        if simulation.bus is not None:
            simulation.bus.restore(BusState(**_group(self.arrays, "bus/")))


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
    """What a run left: series, density snapshots, scene, provenance, checkpoint.

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

    def __getitem__(self, name: str) -> Array:
        if name not in self.series:
            raise MyobridgeError(f"the result has no series '{name}'. {nearest(name, self.series)}")
        return self.series[name]

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write beside, then rename: whatever happens meanwhile, `path` is always a complete file."""
        import h5py

        target = Path(path)
        beside = target.with_name(target.name + ".part")
        with h5py.File(beside, "w") as file:
            for name, rows in self.series.items():
                file[f"series/{name}"] = rows
            file["series"].attrs["sites"] = self.sites
            for number, snapshot in enumerate(self.densities):
                group = file.create_group(f"density/{number:04d}")
                group.attrs["time"] = snapshot.time
                group["position"] = snapshot.position
                group["fraction"] = snapshot.fraction
            file["scene"] = self.scene
            file.create_group("provenance").attrs.update(self.provenance)
            checkpoint = file.create_group("checkpoint")
            checkpoint.attrs.update(self.checkpoint.scalars)
            for name, array in self.checkpoint.arrays.items():
                checkpoint[name] = array
        os.replace(beside, target)
        return target

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
                    np.asarray(file["series"].attrs["sites"]),
                )
        except (OSError, KeyError) as error:
            raise MyobridgeError(f"{source}: is not a result of myobridge ({error})") from None


def _visit(group: Any, into: dict[str, Array]) -> None:
    import h5py

    def keep(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset):
            into[name] = item[...]

    group.visititems(keep)
