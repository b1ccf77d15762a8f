"""Page of an atlas, in Markdown: what was found, case by case, with the numbers."""

from __future__ import annotations

from collections.abc import Iterator

from myobridge.atlas.catalogue import QUANTITIES
from myobridge.atlas.cell import Finding
from myobridge.atlas.chart import Chart
from myobridge.interfaces import Limit, StabilityCase

__all__ = ["page"]

_MARKS = {"holds": "holds", "fails": "fails", "not applicable": "-"}
# Columns of every table, where any of its rows has them.
_SHOWN = ("energy_growth", "energy_loss", "constraint_error", "iterations", "halvings")


def page(chart: Chart, picture: str = "") -> str:
    """The whole page."""
    return "\n".join(_lines(chart, picture)).rstrip() + "\n"


def _lines(chart: Chart, picture: str) -> Iterator[str]:
    counts = chart.counts()
    yield "# Stability atlas"
    yield ""
    command = "myobridge stability --full" if chart.full else "myobridge stability"
    yield f"Written by `{command} --docs`; not edited by hand. Every hard case against every installed method that goes"
    yield "with it. The default method must hold every case; some baselines must fail, where theory says that they do."
    yield "[The guide](guide.md#how-stable-is-a-method) says how to run it, [the page for authors](plugins.md) how a"
    yield "method or a case joins."
    yield ""
    said = f"{len(chart.findings)} cells: {counts['holds']} hold, {counts['fails']} fail, "
    said += f"{counts['not applicable']} do not apply; {counts['surprises']} differ from what is expected."
    yield said
    yield ""
    yield "`default` is the scene without a word about the method: `energy_momentum` with `splitting` where there is"
    yield "inertia, `quasi_static` with `corrected` where there is none, and the strategy of the scene without time."
    yield "Energy growth is the largest rise, relative to the energy at the start and what was supplied; energy loss is"
    yield "what is missing at the end; constraint error is the largest relative residual of the constraint."
    yield ""
    if picture:
        yield f"![Heat map of the atlas]({picture})"
        yield ""
    if chart.surprises:
        yield "## What differs from what is expected"
        yield ""
        for finding in chart.surprises:
            yield f"- `{finding.row}`, `{finding.method}`: {_plain(finding.surprise)}. {_plain(finding.why)}".rstrip()
        yield ""
    for name, case in chart.cases.items():
        yield from _case(chart, name, case)


def _case(chart: Chart, name: str, case: StabilityCase) -> Iterator[str]:
    findings = [finding for finding in chart.findings if finding.case == name]
    yield f"## {name}"
    yield ""
    yield f"{case.summary[:1].upper()}{case.summary[1:]}."
    must = ", ".join(_limit(limit) for limit in case.limits)
    if case.refused_with:
        must = f"refused with a message that says '{case.refused_with}'"
    yield f"Must hold: {must or 'it completes'}."
    yield ""
    extra = [limit.quantity for limit in case.limits]
    extra += [quantity for finding in findings for quantity in finding.predicted]
    wanted = list(dict.fromkeys([*_SHOWN, *extra, *(("largest_step",) if chart.full else ())]))
    shown = [quantity for quantity in wanted if any(quantity in finding.measured for finding in findings)]
    yield "| variant | method | | " + " | ".join(_heading(quantity) for quantity in shown) + " | s | why |"
    yield "|---" * (len(shown) + 5) + "|"
    for finding in findings:
        if finding.outcome != "not applicable":
            yield _row(finding, shown)
    yield ""
    apart = {finding.method: finding.why for finding in findings if finding.outcome == "not applicable"}
    if apart:
        yield "Do not apply: " + "; ".join(f"`{method}` ({_plain(why)})" for method, why in apart.items()) + "."
        yield ""


def _row(finding: Finding, shown: list[str]) -> str:
    mark = _MARKS[finding.outcome] + (" **(!)**" if finding.surprise else "")
    if finding.expected == "fails" and not finding.surprise:
        mark += ", as it must"
    values = [_value(finding, quantity) for quantity in shown]
    why = finding.why if not finding.because or finding.expected == "holds" else f"{finding.why} ({finding.because})"
    cells = [f"`{finding.variant}`" if finding.variant else "", f"`{finding.method}`", mark, *values]
    return "| " + " | ".join([*cells, f"{finding.seconds:.1f}", _plain(why)]) + " |"


def _value(finding: Finding, quantity: str) -> str:
    if quantity not in finding.measured:
        return ""
    value = finding.measured[quantity]
    said = "not finite" if value is None else f"{value:.3g}"
    if quantity == "largest_step" and finding.beyond:
        said = f"> {said}"
    if finding.predicted.get(quantity) is not None:
        said += f" (predicted {finding.predicted[quantity]:.3g})"
    return said


def _heading(quantity: str) -> str:
    words, unit = QUANTITIES.get(quantity, (quantity.replace("_", " "), "-"))
    return words if unit == "-" else f"{words} [{unit}]"


def _limit(limit: Limit) -> str:
    low, high = limit.at_least != float("-inf"), limit.at_most != float("inf")
    ends = [f"at least {limit.at_least:g}"] if low else []
    ends += [f"at most {limit.at_most:g}"] if high else []
    return f"{_heading(limit.quantity)} {' and '.join(ends)}"


def _plain(text: str) -> str:
    """Text that fits in a cell of a table and on a line."""
    flat = " ".join(text.split()).replace("|", "\\|").rstrip(".")
    return flat if len(flat) <= 300 else flat[:297] + "..."
