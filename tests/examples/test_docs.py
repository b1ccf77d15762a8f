"""Every block of code in the documentation runs, and says what the page says that it says.

In a page, top to bottom, in one empty folder: a block whose first line names a file (``# spring.toml``) is written
there; ``python`` runs in one namespace; of ``console`` the lines after ``$`` run in this process, and the lines below
must be in what they print; ``text`` must be in what the block above printed (``...`` stands for what is left out).
A comment above a block says otherwise: ``<!-- not run: reason -->``, ``<!-- exit code 2 -->``.
"""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import matplotlib
import pytest

from myobridge.cli import main

DOCS = Path(__file__).parents[2] / "docs"
PAGES = sorted(str(page.relative_to(DOCS)) for page in DOCS.rglob("*.md"))


@pytest.mark.parametrize("page", PAGES)
def test_every_block_runs(page, blocks, tmp_path, monkeypatch, capsys) -> None:
    matplotlib.use("Agg")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("COLUMNS", "110")
    namespace: dict[str, object] = {"__name__": "docs"}
    said = ""
    for block in blocks(page):
        where = f"docs/{page}:{block.line}"
        if block.comment.startswith("not run"):
            assert len(block.comment) > len("not run: because"), f"{where}: give the reason"
        elif block.file:
            target = tmp_path / block.file
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(block.text, encoding="utf-8")
        elif block.language == "python":
            exec(compile(block.text, where, "exec"), namespace)
            said = capsys.readouterr().out
        elif block.language == "console":
            expected = 2 if block.comment == "exit code 2" else 0
            for command, answer in _commands(block.text):
                words = shlex.split(command, comments=True)
                assert words[0] == "myobridge", f"{where}: {command} is no command of the project"
                assert main(words[1:]) == expected, f"{where}: {command}\n{capsys.readouterr()}"
                streams = capsys.readouterr()
                _contains(streams.out + streams.err, answer, where)
        elif block.language == "text":
            _contains(said, block.text.splitlines(), where)
        else:
            assert block.language == "plain", f"{where}: '{block.language}' is neither run nor marked"


def _commands(text: str) -> list[tuple[str, list[str]]]:
    """Commands of a console block, each with the lines that are shown below it."""
    found: list[tuple[str, list[str]]] = []
    for line in text.replace("\\\n", " ").splitlines():
        if line.startswith("$ "):
            found.append((line[2:], []))
        else:
            found[-1][1].append(line)
    return found


def _contains(output: str, lines: list[str], where: str) -> None:
    """All shown lines are in the output, whatever the spaces between the words."""
    flat = " ".join(output.split())
    for line in lines:
        for piece in filter(str.strip, line.split("...")):
            assert " ".join(piece.split()) in flat, f"{where}: '{piece}' is not in\n{output}"


@pytest.mark.parametrize("page", PAGES)
def test_every_link_leads_somewhere(page) -> None:
    written = re.sub(r"```.*?```", "", (DOCS / page).read_text(encoding="utf-8"), flags=re.DOTALL)
    for target in re.findall(r"\]\(([^)#]+?)(?:#[^)]*)?\)", written):
        if "://" not in target:
            assert ((DOCS / page).parent / target).exists(), f"docs/{page}: {target}"


@pytest.mark.sources
@pytest.mark.parametrize("page", PAGES)
def test_every_file_that_is_named_exists(page) -> None:
    written = re.sub(r"```.*?```", "", (DOCS / page).read_text(encoding="utf-8"), flags=re.DOTALL)
    for named in re.findall(r"`((?:core|plugins|tests|examples|docs)/[\w./-]+\.\w+)", written):
        assert (DOCS.parent / named).exists(), f"docs/{page}: {named}"
