"""Pictures and report of a study; the report in a real browser, where there is one."""

from __future__ import annotations

import itertools
import json
import os
import re
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

import myobridge as mb
from myobridge.study.families import families
from myobridge.study.measurement import Measurement
from myobridge.study.report import report, write_report
from myobridge.study.result import StudyResult
from myobridge.study.rows import Row
from myobridge.study.variants import crossed

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


def result(scenes, tolerance: float | None = 1e-2) -> StudyResult:
    """Result with known numbers: error 1 / cost^2 in one family, 0.1 / cost in the other, and one that failed."""
    ways = {"way": {"quick": {}, "</script><b>slow": {"integrator.plugin": "bathe"}}}
    study = mb.Study(
        scene=mb.Scene.from_toml(scenes["spring"]),
        vary=[{**ways, "scene.step": [4e-3, 2e-3, 1e-3]}, {"scene.step": [5e-4]}],
        tolerance=tolerance,
    )
    rows = []
    for place, variant in enumerate(crossed(study.vary)):
        if not variant.family:
            rows.append(Row(variant=variant, reason="the worker that ran it died, 2 times"))
            continue
        cost = 2.0 ** (place % 3) * (1.0 if variant.family == "quick" else 3.0)
        error = 0.02 / cost**2 if variant.family == "quick" else 0.1 / cost
        rows.append(Row(variant=variant, error=error, cpu=cost, wall=cost, runs=1, rounds=(cost,), steps=10 + place))
    return StudyResult(study, tuple(rows), {}, {})


def test_slopes_are_those_of_the_families(scenes) -> None:
    quick, slow = families(result(scenes))
    assert quick.slope == pytest.approx(-2.0)
    assert slow.slope == pytest.approx(-1.0)
    assert quick.label == "quick (slope -2.0)"


def test_pictures_are_drawn(scenes, tmp_path) -> None:
    files = {path.name: path for path in result(scenes).save(tmp_path)}
    assert set(files) == {"study.json", "work_precision.png", "work_precision.svg", "report.html"}
    assert files["work_precision.png"].read_bytes().startswith(b"\x89PNG")
    drawn = ElementTree.parse(files["work_precision.svg"]).getroot()
    assert drawn.tag.endswith("svg")
    said = json.loads(files["study.json"].read_text(encoding="utf-8"))
    assert len(said["rows"]) == 7
    assert said["recommended"] == "--set scene.step=0.002"
    assert said["rows"][-1]["cpu"] is None


def test_the_page_is_whole_without_a_browser(scenes) -> None:
    page = report(result(scenes))
    assert "default-src 'none'" in page
    ours = page.replace(page[page.index("<script>") : page.index('<script type="application/json"')], "")
    assert not re.findall(r"https?://", ours), "nothing is asked for from a network"
    assert "<!--" not in ours, "every part has been filled in"
    assert "&lt;/script&gt;&lt;b&gt;slow" in ours, "names are text"
    assert ours.count("<script") == 2


def test_what_cannot_be_written_is_told(scenes, tmp_path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(mb.MyobridgeError, match=r"file: cannot be written \(File exists\)"):
        result(scenes).save(tmp_path / "file")


def test_a_measurement_says_where() -> None:
    assert Measurement().host == os.uname().nodename


# ---------------------------------------------------------------------- in a browser


class Page:
    """A page in a headless browser, spoken to through the browser's own pipe."""

    def __init__(self, folder: Path) -> None:
        ask, tell = os.pipe(), os.pipe()
        words = [
            BROWSER,
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--remote-debugging-pipe",
            "--no-first-run",
        ]
        words += ["--disable-background-networking", "--disable-component-update", f"--user-data-dir={folder}"]
        line = f'exec "$@" 3<&{ask[0]} 4>&{tell[1]}'
        with (folder / "log").open("wb") as log:
            self.process = subprocess.Popen(
                ["bash", "-c", line, "bash", *words], pass_fds=(ask[0], tell[1]), stdout=log, stderr=log
            )
        os.close(ask[0])
        os.close(tell[1])
        self._ask, self._tell, self._rest = ask[1], tell[0], b""
        self._numbers = itertools.count(1)
        self._session: str | None = None
        self.events: list[dict[str, Any]] = []
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.call(f"{domain}.enable")

    def call(self, method: str, **said: Any) -> dict[str, Any]:
        """Answer of the browser."""
        number = next(self._numbers)
        message: dict[str, Any] = {"id": number, "method": method, "params": said}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._ask, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") == number:
                assert "error" not in answer, answer
                return answer["result"]
            self.events.append(answer)

    def _next(self) -> dict[str, Any]:
        while b"\0" not in self._rest:
            more = os.read(self._tell, 1 << 20)
            assert more, "the browser has gone"
            self._rest += more
        message, _, self._rest = self._rest.partition(b"\0")
        return json.loads(message)

    def value(self, expression: str) -> Any:
        """Value of an expression in the page."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def open(self, path: Path, width: int, height: int) -> None:
        """Open a file in a window of a size, and wait until it has been drawn."""
        small = width < 600
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=small)
        self.events.clear()
        self.call("Page.navigate", url=path.as_uri())
        until = time.monotonic() + 60.0
        drawn = "document.readyState === 'complete' && !!document.querySelector('.main-svg')"
        # Until this page has loaded, the answer may be that of the page before.
        while not (self.value(drawn) and any(event["method"] == "Page.loadEventFired" for event in self.events)):
            assert time.monotonic() < until, "the page was not drawn within a minute"
            time.sleep(0.05)

    def complaints(self) -> list[Any]:
        """Exceptions, messages of error, and requests for anything but the page itself."""
        found: list[Any] = []
        for event in self.events:
            method, said = event["method"], event["params"]
            if method == "Runtime.exceptionThrown" or (
                method == "Log.entryAdded" and said["entry"]["level"] == "error"
            ):
                found.append(said)
            if method == "Runtime.consoleAPICalled" and said["type"] in ("error", "warning"):
                found.append(said)
            if method == "Network.requestWillBeSent" and not said["request"]["url"].startswith(
                ("file:", "data:", "blob:")
            ):
                found.append(said["request"]["url"])
        return found

    def close(self) -> None:
        """End the browser."""
        os.close(self._ask)
        os.close(self._tell)
        self.process.kill()
        self.process.wait()


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    if BROWSER is None:
        pytest.skip("no chromium here; apt-get install chromium")
    page = Page(tmp_path_factory.mktemp("browser"))
    yield page
    page.close()


@pytest.fixture(scope="module")
def opened(scenes, tmp_path_factory, browser) -> Callable[[int, int], Page]:
    """Open the report in a window of that size."""
    path = write_report(result(scenes), tmp_path_factory.mktemp("report") / "report.html")

    def at(width: int, height: int) -> Page:
        browser.open(path, width, height)
        return browser

    return at


def test_it_loads_draws_and_asks_for_nothing(opened) -> None:
    page = opened(1200, 900)
    assert page.complaints() == []
    assert page.value("document.querySelectorAll('#plot-error .scatterlayer .trace').length") >= 4
    assert page.value("document.querySelectorAll('#plot-error .scatterlayer path.point').length") > 10
    assert page.value("document.getElementById('recommended').textContent") == "--set scene.step=0.002"
    assert "effects = " in page.value("document.querySelectorAll('pre')[1].textContent")
    assert "version myobridge" in page.value("document.querySelectorAll('pre')[2].textContent")
    requests = [event for event in page.events if event["method"] == "Network.requestWillBeSent"]
    assert len([event for event in requests if event["params"]["request"]["url"].startswith("file:")]) == 1


def test_the_policy_is_at_work(opened) -> None:
    page = opened(1200, 900)
    assert page.value("fetch('http://127.0.0.1:9/').then(() => 'asked', () => 'refused')") == "refused"
    assert any("Content Security Policy" in str(complaint) for complaint in page.complaints())


def test_headings_sort(opened) -> None:
    page = opened(1200, 900)
    column = "[...document.querySelectorAll('#rows tbody tr')].map(row => row.cells[{}].dataset.value)"
    press = "document.querySelectorAll('#rows th button')[{}].click()"
    page.value(press.format(1))
    rising = page.value(column.format(1))
    numbers = [float(value) for value in rising if value]
    assert numbers == sorted(numbers)
    assert len(set(numbers)) == 6
    assert rising[-1] == "", "what has no number comes last"
    page.value(press.format(1))
    falling = [float(value) for value in page.value(column.format(1)) if value]
    assert falling == numbers[::-1]
    page.value(press.format(0))
    names = page.value("[...document.querySelectorAll('#rows tbody tr')].map(row => row.cells[0].textContent)")
    assert len(names) == 7
    assert names.index("quick, step 0.001") < names.index("quick, step 0.002") < names.index("step 0.0005")


def test_it_is_readable_on_a_phone(opened) -> None:
    page = opened(380, 800)
    assert page.complaints() == []
    assert page.value("document.documentElement.scrollWidth") <= 380, "the page itself does not scroll sideways"
    width = page.value("document.querySelector('#plot-error .main-svg').getBoundingClientRect().width")
    assert 300 <= width <= 380
    assert page.value("parseFloat(getComputedStyle(document.querySelector('#recommendation p')).fontSize)") >= 14.0
    assert page.value("document.querySelector('.table').scrollWidth > document.querySelector('.table').clientWidth")
