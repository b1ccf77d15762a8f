"""The stability atlas: what must hold holds, what must fail fails, with the number that theory gives.

Cheap cells are tried with every change; the whole quick atlas is a slow study.
"""

from __future__ import annotations

import pytest

import myobridge as mb

CHEAP = {
    "staggering:*": (),
    "spring_growth": (),
    "stiff_rates": (),
    "no_activation": (),
    "inf_sup:triangle": ("default", "P1-P0"),
    "full_tension": ("default", "printed"),
    "inconsistent_start": ("default",),
    "projected_start": ("default",),
    "free_flight": ("default",),
    "release_30": ("half_explicit", "default"),
    "release_50:0.004": ("default",),
    "bulk_modulus:1e4": ("default",),
    "light_body:1.1e-09": ("default",),
    "slivers:along": ("default",),
    "contraction:stiffness x 100": ("default",),
    "closed_ledger": ("default",),
}


def told(chart: mb.Chart) -> str:
    return "\n".join(f"{item.row}, {item.method}: {item.surprise}. {item.why}" for item in chart.surprises)


@pytest.mark.parametrize("case", CHEAP)
def test_cheap_cells_are_as_expected(case: str) -> None:
    chart = mb.Atlas([case], CHEAP[case]).run(workers=0)
    for finding in chart.findings:
        print(f"{finding.row}, {finding.method}: {finding.outcome} {finding.why} {dict(finding.measured)}")
    assert any(finding.method == "default" and finding.outcome == "holds" for finding in chart.findings)
    assert not chart.surprises, told(chart)


def test_expectations_are_not_empty() -> None:
    """Baselines fail, and three numbers come from theory."""
    cells = mb.Atlas().cells
    failing = [cell for cell in cells if cell.expectation.outcome == "fails"]
    agreed = {quantity for cell in cells for quantity in cell.expectation.agrees}
    assert len(failing) > 20
    assert agreed == {"amplification", "growth_rate", "largest_step"}
    assert {cell.case.__class__.__name__ for cell in cells if cell.method.name == "default"} == {
        type(case).__name__ for case in mb.Atlas().cases.values()
    }


@pytest.mark.slow
def test_the_whole_quick_atlas_is_as_expected(tmp_path) -> None:
    chart = mb.Atlas().run(tmp_path)
    print(chart.counts())
    assert not chart.surprises, told(chart)
