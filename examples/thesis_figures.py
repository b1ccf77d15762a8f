"""The thesis' figures of the micro scale, from the scenes beside this file: 6 to 9 (spring), 17, 18, 19 (moments).

``python examples/thesis_figures.py [FOLDER]`` draws them. Every function runs its scenes and returns their results.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path

import myobridge as mb

HERE = Path(__file__).parent
UPWIND = {"cross_bridges.discretisation": "upwind"}
EULER = {"cross_bridges.discretisation": "moving_frame_euler"}
MOMENTS = {
    "huxley": {},
    "huxley, empty": {"cross_bridges.start": "empty"},
    "moments": {"cross_bridges.plugin": "distributed_moment"},
    "moments, empty": {"cross_bridges.plugin": "distributed_moment", "cross_bridges.start": "empty"},
}


def one_state() -> Mapping[str, mb.Result]:
    """Figures 6 and 7: energy and density without attachment and detachment."""
    scene = HERE / "thesis_spring_one_state.toml"
    return {"moving frame": mb.run(scene), "upwind": mb.run(scene, settings=UPWIND)}


def two_state() -> Mapping[str, mb.Result]:
    """Figures 8 and 9: energy and density with attachment and detachment, at a step of 15 ms."""
    scene = HERE / "thesis_spring_two_state.toml"
    return {
        "exact": mb.run(scene),
        "Euler frame": mb.run(scene, settings=EULER),
        "upwind": mb.run(scene, settings=UPWIND),
    }


def quasi_steady() -> mb.Result:
    """Figure 17: density of steady shortening."""
    return mb.run(HERE / "thesis_quasi_steady.toml")


def moments(name: str) -> Mapping[str, mb.Result]:
    """Figure 18 (``thesis_lengthening``) or 19 (``thesis_shortening``): both models from both starts."""
    return {label: mb.run(HERE / f"{name}.toml", settings=settings) for label, settings in MOMENTS.items()}


def main(folder: Path) -> None:
    """Draw all figures into `folder`."""
    import matplotlib.pyplot as plt

    def energies(axis, results, keys) -> None:
        for label, result in results.items():
            for key, style in keys.items():
                axis.plot(1e3 * result["time"], 1e3 * result[f"energy/{key}"], style, label=f"{label}: {key}")
        axis.set(xlabel="time [ms]", ylabel="energy [mJ]")
        axis.legend(fontsize=7)

    def densities(axis, result, title) -> None:
        for snapshot in result.densities:
            axis.plot(snapshot.position[0], snapshot.fraction[0], label=f"{1e3 * snapshot.time:.0f} ms")
        axis.set(xlabel="displacement [reach]", ylabel="attached fraction [-]", title=title, xlim=(-4, 5))
        axis.legend(fontsize=7)

    first = one_state()
    figure, axes = plt.subplots(1, 3, figsize=(13, 3.6), layout="constrained")
    for label, result in first.items():
        total = result["energy/kinetic"] + result["energy/elastic"] + result["energy/cross_bridge"]
        axes[0].plot(1e3 * result["time"], 1e3 * total, label=label)
    axes[0].set(xlabel="time [ms]", ylabel="total energy [mJ]", title="Figure 6", ylim=(0, None))
    axes[0].legend()
    for axis, (label, result) in zip(axes[1:], first.items(), strict=True):
        densities(axis, result, f"Figure 7: {label}")
    figure.savefig(folder / "thesis_figures_6_7.png", dpi=110)

    second = two_state()
    figure, axes = plt.subplots(1, 4, figsize=(17, 3.6), layout="constrained")
    energies(axes[0], second, {"attached": "-", "detached": "--"})
    axes[0].set_title("Figure 8")
    for axis, (label, result) in zip(axes[1:], second.items(), strict=True):
        densities(axis, result, f"Figure 9: {label}, step 15 ms")
    figure.savefig(folder / "thesis_figures_8_9.png", dpi=110)

    figure, axis = plt.subplots(figsize=(5, 3.6), layout="constrained")
    densities(axis, quasi_steady(), "Figure 17: v = -30/s")
    axis.set_xlim(-1.5, 1.5)
    figure.savefig(folder / "thesis_figure_17.png", dpi=110)

    for number, name in ((18, "thesis_lengthening"), (19, "thesis_shortening")):
        figure, axes = plt.subplots(1, 3, figsize=(13, 3.6), layout="constrained")
        for label, result in moments(name).items():
            for k, axis in enumerate(axes):
                axis.plot(1e3 * result["time"], result[f"Q{k}"][:, 0], "--" if "moments" in label else "-", label=label)
                axis.set(xlabel="time [ms]", ylabel=f"Q{k}")
        axes[0].legend(fontsize=7)
        axes[1].set_title(f"Figure {number}")
        figure.savefig(folder / f"thesis_figure_{number}.png", dpi=110)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path())
