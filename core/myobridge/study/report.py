"""Report of a study: one page of HTML that needs nothing else, neither a network nor a file beside it.

The policy in its head forbids every request, so the browser itself holds the page to that.
"""

from __future__ import annotations

import html
import json
import math
from collections.abc import Iterator, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

from myobridge.errors import MyobridgeError
from myobridge.results import provenance
from myobridge.study.families import families
from myobridge.study.plot import COLOURS, KINDS
from myobridge.study.result import StudyResult
from myobridge.study.rows import Row

__all__ = ["report", "write_report"]

_CONFIG = {"responsive": True, "displaylogo": False, "displayModeBar": False}


def write_report(result: StudyResult, path: Path) -> Path:
    """Write the page; raises OSError where that cannot be done."""
    path.write_text(report(result), encoding="utf-8")
    return path


def report(result: StudyResult) -> str:
    """The page as text."""
    study = result.study
    text = resources.files("myobridge.study").joinpath("report.html").read_text(encoding="utf-8")
    kinds = _kinds(result)
    figures = {kind: _figure(result, kind) for kind in kinds}
    said = {
        "title": html.escape(f"Cost of accuracy: {study.title}"),
        "recommendation": _recommendation(result),
        "plots": "\n".join(
            f'<div class="plot" id="plot-{kind}" role="img" aria-label="{KINDS[kind]} against CPU time"></div>'
            for kind in kinds
        ),
        "reference": "".join(f"<li>{html.escape(line)}</li>" for line in _references(result)),
        "head": "".join(
            f'<th data-kind="{kind}"><button type="button">{html.escape(name)}</button></th>'
            for name, kind in _columns(result)
        ),
        "rows": "\n".join(_lines(result)),
        "scene": html.escape(study.scene_of({}).to_toml()),
        "versions": html.escape("\n".join(f"{name}: {value}" for name, value in provenance({}).items())),
        "figures": _embedded({"figures": figures, "config": _CONFIG}),
        "plotly": _plotly(),
    }
    for name, value in said.items():
        text = text.replace(f"<!--{name}-->", value)
    return text


def _kinds(result: StudyResult) -> list[str]:
    return list(KINDS)[: 2 if len({row.variant.model for row in result.rows}) > 1 else 1]


def _plotly() -> str:
    """The script that draws, as the installed package brings it."""
    try:
        return resources.files("plotly").joinpath("package_data", "plotly.min.js").read_text(encoding="utf-8")
    except (ImportError, OSError) as error:
        raise MyobridgeError(f"report.html: plotly's script is not found ({error}); pip install plotly") from None


def _embedded(data: Any) -> str:
    """JSON that may stand inside a script element."""
    return json.dumps(data, allow_nan=False).replace("<", "\\u003c")


def _figure(result: StudyResult, kind: str) -> dict[str, Any]:
    traces: list[dict[str, Any]] = []
    for place, family in enumerate(families(result, kind)):
        colour = {"color": COLOURS[place % len(COLOURS)]}
        same = {"legendgroup": str(place), "name": family.label}
        traces.append(_trace(family.rows, kind, mode="markers", marker=colour | {"opacity": 0.4}) | same)
        traces.append(_trace(family.front, kind, mode="lines+markers", line=colour, marker=colour) | same)
        traces[-2]["showlegend"] = False
    if kind == "error":
        ring = {"symbol": "circle-open", "size": 15, "color": "black"}
        traces.append(_trace(result.pareto(), kind, mode="markers", marker=ring) | {"name": "Pareto front"})
    shapes, tolerance = [], result.study.tolerance
    if tolerance is not None:
        ends = {"x0": 0, "x1": 1, "y0": tolerance, "y1": tolerance}
        shapes.append({"type": "line", "xref": "paper", "line": {"dash": "dash", "color": "gray", "width": 1}} | ends)
    axis = {"type": "log", "exponentformat": "power", "automargin": True}
    layout = {
        "xaxis": axis | {"title": {"text": "CPU time [s]"}},
        "yaxis": axis | {"title": {"text": KINDS[kind]}},
        "legend": {"orientation": "h", "y": -0.25},
        "margin": {"l": 60, "r": 15, "t": 15, "b": 50},
        "shapes": shapes,
        "template": {},
    }
    return {"data": traces, "layout": layout}


def _trace(rows: Sequence[Row], kind: str, **said: Any) -> dict[str, Any]:
    return {
        "type": "scatter",
        "x": [row.cpu for row in rows],
        "y": [getattr(row, kind) for row in rows],
        "text": [html.escape(row.label) for row in rows],
        "hovertemplate": "%{text}<br>%{x:.3g} s, %{y:.2e}<extra></extra>",
        **said,
    }


def _recommendation(result: StudyResult) -> str:
    tolerance = result.study.tolerance
    if tolerance is None:
        return "<p>No tolerance was given, so nothing is recommended.</p>"
    best = result.recommend()
    if best is None:
        return f"<p>No variant meets the tolerance of {tolerance:g}.</p>"
    command = html.escape(best.command or "the scene as it stands")
    return (
        f"<p>Cheapest variant that meets {tolerance:g}: <strong>{html.escape(best.label)}</strong>, error "
        f"{best.error:.1e}, {best.cpu:.3g} s CPU.</p><pre id='recommended'>{command}</pre>"
    )


def _references(result: StudyResult) -> Iterator[str]:
    for model, found in result.standards.items():
        state = "" if found.converged else "; its levels do not converge, so make it finer"
        yield f"{model or 'scene as it stands'}: estimated error {found.error:.1e}{state}"
    if result.study.reference.closed_form is not None:
        yield "closed form"
    yield from dict.fromkeys(result.failures.values())


def _columns(result: StudyResult) -> list[tuple[str, str]]:
    from myobridge.study.tables import COLUMNS

    work = [(COLUMNS[name], "number") for name in _work(result)]
    numbers = ["error", "discretisation", "model error", "CPU [s]", "spread [%]", "wall [s]", "steps"]
    return [("variant", "text"), *((name, "number") for name in numbers), *work, ("remark", "text")]


def _work(result: StudyResult) -> list[str]:
    from myobridge.study.tables import COLUMNS

    return [name for name in COLUMNS if any(row.work.get(name) for row in result.rows)]


def _lines(result: StudyResult) -> Iterator[str]:
    front, best = result.pareto(), None if result.study.tolerance is None else result.recommend()
    others = [row for row in result.rows if not row.measured]
    for row in (*result.measured, *others):
        marks = [word for word, there in (("recommended", row is best), ("Pareto", row in front)) if there]
        numbers = [row.error, row.discretisation_error, row.model_error, row.cpu, 100.0 * row.spread, row.wall]
        numbers += [float(row.steps), *(float(row.work.get(name, 0)) for name in _work(result))]
        cells = "".join(
            f'<td data-value="{value!r}">{_shown(value)}</td>' if math.isfinite(value) else '<td data-value=""></td>'
            for value in numbers
        )
        kind = "best" if row is best else "out" if row.reason else ""
        remark = html.escape(row.reason or ", ".join(marks))
        label = f'<td title="{html.escape(row.command)}">{html.escape(row.label)}</td>'
        yield f'<tr class="{kind}">{label}{cells}<td class="remark">{remark}</td></tr>'


def _shown(value: float) -> str:
    return f"{value:,.0f}" if value == int(value) and abs(value) < 1e6 else f"{value:.3g}"
