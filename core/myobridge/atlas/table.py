"""Tables of an atlas for the terminal."""

from __future__ import annotations

from rich.console import Group
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from myobridge.atlas.cell import Finding
from myobridge.atlas.chart import Chart

__all__ = ["chart_table", "surprises_text"]

_STYLES = {"holds": "green", "fails": "yellow", "not applicable": "dim"}


def chart_table(chart: Chart) -> Group:
    """One line a row of the atlas: which methods hold, which fail; then what differs from what is expected."""
    table = Table(title="stability atlas", title_justify="left")
    table.add_column("case", overflow="fold")
    for heading in ("default", "hold", "fail", "do not apply"):
        table.add_column(heading, overflow="fold")
    for row in chart.rows:
        findings = [finding for finding in chart.findings if finding.row == row]
        default = [finding for finding in findings if finding.axis == "default"]
        others = [finding for finding in findings if finding.axis != "default"]
        cells = [_names(others, outcome) for outcome in ("holds", "fails", "not applicable")]
        table.add_row(escape(row), _said(default), *cells)
    counts = chart.counts()
    said = (
        f"{len(chart.findings)} cells: {counts['holds']} hold, {counts['fails']} fail, "
        f"{counts['not applicable']} do not apply; {counts['surprises']} differ from what is expected (!)"
    )
    return Group(table, Text(said), surprises_text(chart))


def surprises_text(chart: Chart) -> Text:
    """One line for each finding that differs from what is expected."""
    lines = [f"{finding.row}, {finding.method}: {finding.surprise}. {finding.why}" for finding in chart.surprises]
    return Text("\n".join(line.rstrip() for line in lines), style="red")


def _said(findings: list[Finding]) -> Text:
    return Text(" ").join(
        Text(f"{finding.outcome}{' (!)' if finding.surprise else ''}", style=_style(finding)) for finding in findings
    )


def _names(findings: list[Finding], outcome: str) -> Text:
    return Text(", ").join(
        Text(f"{finding.method}{' (!)' if finding.surprise else ''}", style=_style(finding))
        for finding in findings
        if finding.outcome == outcome
    )


def _style(finding: Finding) -> str:
    return "bold red" if finding.surprise else _STYLES[finding.outcome]
