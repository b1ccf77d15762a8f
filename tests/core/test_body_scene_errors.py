"""Mistakes in scenes with a body: one line each, with the key, what is allowed and the nearest match; no traceback."""

from __future__ import annotations

from pathlib import Path

import pytest

from myobridge.cli import main

LIFTING = Path(__file__).parents[2] / "examples" / "lifting.toml"

MISTAKES: dict[str, tuple[list[str], str]] = {
    "pair of other cells": (
        ["solid.elements=Q2-P1disc"],
        "solid.elements: is 'Q2-P1disc', which does not exist on tri",
    ),
    "pair without multiplier": (
        ["solid.elements=P2"],
        "the scene needs a multiplier for the effect 'incompressibility'",
    ),
    "boundary of a load": (["load.0.boundary=rigth"], "load[0].boundary: the mesh has no boundary 'rigth'. Allowed: "),
    "boundary, nearest": (["support.0.boundary=lef"], "support[0].boundary: .* Did you mean 'left'?"),
    "bulk modulus": (["solid.bulk_modulus=-1"], "solid.bulk_modulus: is -1; expected a number in (0, inf] [Pa]"),
    "effect not called for": (["solid.gravity=9.81"], "belongs to the effect 'gravity'"),
    "negative weight": (
        ["solid.quadrature=3"],
        "solid.quadrature: is 3, whose rule on tetrahedra has a negative weight",
    ),
    "material": (["solid.material.plugin=mooney"], "solid.material.plugin: .* Did you mean 'mooney_rivlin'?"),
    "component": (["support.0.components=q"], "support[0].components: is 'q'; expected letters out of x, y, z"),
    "component in the plane": (["support.0.components=z"], "holds 'z', and the body is plane: expected x, y"),
    "values of components": (["support.0.displacement=[1.0, 2.0, 3.0]"], "has 3 values for 2 held components"),
    "fibres between boundaries": (
        ['solid.fibres={plugin="harmonic", start="left", end="rigt"}'],
        "solid.fibres.end: the mesh has no boundary 'rigt'. .* Did you mean 'right'?",
    ),
    "mesh file": (['solid.mesh={plugin="file", file="nix.msh"}'], "solid.mesh.file: .* nix.msh' does not exist"),
    "dimension of a load": (["load.0.gravity=[1, 2, 3]"], "load[0].gravity: .* expected a list of 2 numbers [m/s^2]"),
    "free to slide": (["support.0.components=x"], "can move as a rigid body in one way"),
    "not held at all": (["support.0.boundary=top", "support.0.components=y"], "rigid body in one way"),
    "region": (['solid.region=[{name="tendon"}]'], "region[0].name: the mesh has no subdomain 'tendon'"),
    "supports given twice": (['solid.support=[{boundary="top"}]'], "support[0]: is given, and so is solid.support"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
@pytest.mark.parametrize("verb", ["explain", "run"])
def test_it_is_one_clear_line(mistake: str, verb: str, capsys, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    settings, says = MISTAKES[mistake]
    arguments = [verb, str(LIFTING), *(word for setting in settings for word in ("--set", setting))]
    assert main(arguments) == 2
    said = capsys.readouterr().err
    assert said.startswith("myobridge: ")
    assert said.count("\n") == 1
    for words in says.split(" .* "):
        assert words in said, said
    assert not list(tmp_path.iterdir()), "nothing is written"


def test_a_solver_that_is_absent_is_said_at_once(capsys, monkeypatch) -> None:
    from myobridge_plugins.linear_solver.pardiso import Pardiso

    monkeypatch.setattr(Pardiso, "obstacle", lambda self: "the package is absent")
    settings = ["--set", "continuation.newton.plugin=inexact", "--set", "continuation.newton.linear=pardiso"]
    assert main(["explain", str(LIFTING), *settings]) == 2
    assert (
        "continuation.newton.linear: cannot be used on this machine: the package is absent" in capsys.readouterr().err
    )
