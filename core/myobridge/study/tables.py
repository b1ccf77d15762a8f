"""Tables and sentences of a study for the command line."""

from __future__ import annotations

import math
from os import PathLike

from rich.box import SIMPLE_HEAD
from rich.markup import escape
from rich.table import Table

from myobridge.study.effects import EffectPrices
from myobridge.study.result import StudyResult
from myobridge.study.rows import Row

__all__ = [
    "COLUMNS",
    "effects_price_table",
    "left_out_text",
    "not_priced_text",
    "recommendation_text",
    "reference_text",
    "study_table",
    "written_count",
]

_WIDE = 130
_FEW = 4
COLUMNS = {
    "factorisations": "factorisations",
    "inner_iterations": "inner its",
    "newton_iterations": "Newton its",
    "assembled_elements": "elements",
    "bin_steps": "bin-steps",
}
"""Work that is shown where a study has any, with its heading."""


def study_table(result: StudyResult, width: int = 200) -> Table:
    """One line a variant with a result, the cheapest first; counts of work where `width` has room for them."""
    several = len({row.variant.model for row in result.rows}) > 1
    work = [name for name in COLUMNS if any(row.work.get(name) for row in result.rows)] if width >= _WIDE else []
    table = Table(
        title=escape(f"cost of '{result.study.title}'"), title_justify="left", box=SIMPLE_HEAD, padding=(0, 1)
    )
    table.add_column("variant")
    errors = ["error", *(["discret.", "model"] if several else [])]
    for heading in (*errors, "CPU [s]", "+-", "ratio", "steps", *(COLUMNS[name] for name in work), ""):
        table.add_column(heading, justify="right", no_wrap=True)
    front, best = result.pareto(), _best(result)
    first = best or (result.measured or result.rows)[0]
    for row in result.measured:
        shown = [row.error, *([row.discretisation_error, row.model_error] if several else [])]
        table.add_row(
            escape(row.label),
            *map(_error, shown),
            f"{row.cpu:.3g}",
            f"{50 * row.spread:.0f} %" if row.runs > 1 else "",
            f"{row.ratio(first):.2f}",
            f"{row.steps:,}",
            *(written_count(row.work.get(name, 0)) for name in work),
            "<=" if row is best else "*" if row in front else "",
            style="bold green" if row is best else "",
        )
    return table


def left_out_text(result: StudyResult) -> str:
    """Variants without a result, by the reason."""
    reasons: dict[str, list[str]] = {}
    for row in result.rows:
        if not row.measured:
            reasons.setdefault(row.reason or "no error is known", []).append(row.label)
    lines: list[str] = []
    for reason, labels in reasons.items():
        named = (
            "; ".join(labels) if len(labels) <= _FEW else f"{'; '.join(labels[:_FEW])} and {len(labels) - _FEW} more"
        )
        lines.append(f"without result: {named}: {reason}")
    return "\n".join(lines)


def _best(result: StudyResult) -> Row | None:
    return None if result.study.tolerance is None else result.recommend()


def _error(error: float) -> str:
    return f"{error:.1e}" if math.isfinite(error) else ""


def written_count(amount: int) -> str:
    """A count in few digits."""
    if not amount:
        return ""
    return f"{amount:,}" if amount < 10_000 else f"{amount:.2e}"


def reference_text(result: StudyResult) -> str:
    """What the references are off themselves, in a line each."""
    lines: list[str] = []
    for model, found in result.standards.items():
        whose = f"reference of '{model}'" if model else "reference"
        said = f"{whose}: estimated error {found.error:.1e}"
        if found.distances:
            said += f", from levels {', '.join(f'{distance:.1e}' for distance in found.distances)} apart"
        if not found.converged:
            said += " [red](not converged: make it finer before you trust the table)[/]"
        lines.append(said)
    if result.study.reference.closed_form is not None:
        lines.append("reference: closed form")
    return "\n".join(lines + [f"[red]{escape(why)}[/]" for why in dict.fromkeys(result.failures.values())])


def recommendation_text(result: StudyResult, file: str | PathLike[str]) -> str:
    """The cheapest variant that is good enough, as a line to paste."""
    tolerance = result.study.tolerance
    if tolerance is None:
        return "no tolerance given, so nothing is recommended; --tolerance 1e-2 asks for it"
    best = result.recommend()
    if best is not None:
        return (
            f"recommended for {tolerance:g}: {best.command or 'the scene as it stands'}\n"
            f"  error {best.error:.1e}, {best.cpu:.3g} s CPU"
        )
    off = result.doubt
    if 2.0 * off > tolerance:  # no variant is credited with less
        return f"nothing is recommended for {tolerance:g}: the reference itself is off by {off:.1e}; make it finer"
    least = min((row.error for row in result.measured), default=math.nan)
    beside = f", and the reference may be off by {off:.1e}" if off else ""
    return f"nothing is recommended for {tolerance:g}: the least error of any variant is {least:.1e}{beside}"


def effects_price_table(priced: EffectPrices) -> Table:
    """One line an effect: what it costs, and what it changes."""
    table = Table(
        title=escape(f"price list of '{priced.scene.name}', {priced.cpu:.3g} s CPU as it stands"),
        title_justify="left",
        box=SIMPLE_HEAD,
        padding=(0, 1),
    )
    for name in ("effect", "state"):
        table.add_column(name, no_wrap=True)
    for name in ("costs [s]", "share", "changes"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("by / why not")
    for price in priced.prices:
        known = math.isfinite(price.seconds)
        if not known and price.state == "off":
            continue
        table.add_row(
            price.effect,
            price.state,
            f"{price.seconds:+.3g}" if known else "",
            f"{100 * price.share:+.0f} %" if known else "",
            _change(price.change) if known else "",
            escape(price.said),
            style="" if known else "dim",
        )
    return table


def not_priced_text(priced: EffectPrices) -> str:
    """Effects that the scene does without and that its plugins do not supply, in a line each."""
    left = [price for price in priced.prices if price.state == "off" and not math.isfinite(price.seconds)]
    return "\n".join(f"{price.effect}: {price.said}" for price in left)


def _change(change: float) -> str:
    if change == 0.0:
        return "none"
    return f"{100 * change:.2g} %" if change < 0.1 else f"{100 * change:.0f} %"
