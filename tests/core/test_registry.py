"""Registry: one broken plugin stops nothing else; clashes and unknown names are clear errors."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable
from importlib import metadata
from pathlib import Path

import pytest

from myobridge.errors import PluginError
from myobridge.registry import PluginWarning, Registered, Registry

GOOD = """
from myobridge import Signal, hookimpl

class Seven(Signal):
    "Always seven."
    def value(self, time): return 7.0
    def mean(self, start, end): return 7.0

@hookimpl
def myobridge_signals():
    return {{"{name}": Seven}}
"""


@pytest.fixture
def stranger(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str, str], list[metadata.EntryPoint]]:
    """A distribution on disk with one entry point, as an installer leaves it."""
    monkeypatch.syspath_prepend(str(tmp_path))

    def install(package: str, source: str) -> list[metadata.EntryPoint]:
        module = package.replace("-", "_")
        (tmp_path / f"{module}.py").write_text(source)
        info = tmp_path / f"{module}-1.2.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.2\n")
        (info / "entry_points.txt").write_text(f"[myobridge]\n{package}-signal = {module}\n")
        monkeypatch.delitem(sys.modules, module, raising=False)
        return list(metadata.Distribution.at(info).entry_points)

    return install


BROKEN = {
    "does not import": ("import a_package_that_nobody_has", "ModuleNotFoundError"),
    "raises on import": ("raise RuntimeError('out of cheese')", "out of cheese"),
    "syntax error": ("def f(:", "SyntaxError"),
    "not a subclass": (
        "from myobridge import hookimpl\n@hookimpl\ndef myobridge_signals():\n    return {'odd': int}",
        "not a subclass of Signal",
    ),
    "abstract": (
        "from myobridge import Signal, hookimpl\nclass Half(Signal):\n    def value(self, time): return 0.0\n"
        "@hookimpl\ndef myobridge_signals():\n    return {'half': Half}",
        "lacks mean",
    ),
    "hook raises": (
        "from myobridge import hookimpl\n@hookimpl\ndef myobridge_signals():\n    raise ValueError('no signal')",
        "no signal",
    ),
    "hook returns no mapping": (
        "from myobridge import hookimpl\n@hookimpl\ndef myobridge_signals():\n    return None",
        "AttributeError",
    ),
}


@pytest.mark.parametrize("kind", BROKEN)
def test_a_broken_plugin_gives_one_warning_that_names_it_and_the_rest_works(stranger, kind: str) -> None:
    source, reason = BROKEN[kind]
    points = [*stranger("broken-pack", source), *stranger("good-pack", GOOD.format(name="seven"))]
    points += metadata.entry_points(group="myobridge")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = Registry(points)
    assert [item.category for item in caught] == [PluginWarning]
    message = str(caught[0].message)
    assert "broken-pack-signal" in message
    assert "'broken-pack'" in message
    assert reason in message
    assert found.find("signal", "seven").cls().value(0.0) == 7.0
    assert "spring" in found.names("macro_solid")
    assert not {"odd", "half"} & set(found.names("signal"))


def test_a_plugin_is_listed_with_package_version_and_description(stranger) -> None:
    item = Registry(stranger("good-pack", GOOD.format(name="seven"))).find("signal", "seven")
    assert isinstance(item, Registered)
    assert (item.package, item.version, item.family, item.summary) == ("good-pack", "1.2", "signal", "Always seven.")


def test_a_clash_of_names_names_both_packages(stranger) -> None:
    points = [*stranger("first-pack", GOOD.format(name="seven")), *stranger("second-pack", GOOD.format(name="seven"))]
    with pytest.raises(PluginError) as caught:
        Registry(points)
    for word in ("'seven'", "'first-pack'", "'second-pack'", "function of time"):
        assert word in str(caught.value)


def test_a_stranger_cannot_take_a_built_in_name(stranger) -> None:
    points = [*metadata.entry_points(group="myobridge"), *stranger("good-pack", GOOD.format(name="ramp"))]
    with pytest.raises(PluginError, match=r"'ramp'.*'(good-pack|myobridge)'.*'(good-pack|myobridge)'"):
        Registry(points)


def test_the_same_name_in_two_families_is_no_clash() -> None:
    found = Registry()
    shared = set(found.names("signal")) & set(found.names("sarcomere_density"))
    assert shared, "the built-in 'table' of both families makes this test"
    for name in shared:
        assert found.find("signal", name).cls is not found.find("sarcomere_density", name).cls


def test_an_unknown_name_gets_the_nearest_match_and_all_that_is_allowed() -> None:
    with pytest.raises(PluginError, match=r"unknown cross-bridge model 'hil'.*liouville.*Did you mean 'hill'\?"):
        Registry().find("cross_bridge", "hil")
