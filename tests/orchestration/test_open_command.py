"""`adcs open` says which page shows a run, and opens it only where someone may look at it."""

import os

import pytest

from adcs import AdcsError
from adcs.cli import opening
from adcs.cli.app import app
from tests.invoking import invoke


@pytest.fixture
def opened(tmp_path, monkeypatch):
    """Two runs, `second` the newer one; and the addresses that the browser was asked for."""
    monkeypatch.chdir(tmp_path)
    for age, name in enumerate(("second", "first")):
        page = tmp_path / "results" / name / "report.html"
        page.parent.mkdir(parents=True)
        page.write_text("<html>")
        os.utime(page, (1e9 - age, 1e9 - age))
    for name in ("CI", "DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("adcs.cli.opening.sys.platform", "linux")
    asked = []
    monkeypatch.setattr("adcs.cli.opening.webbrowser.open", lambda address: asked.append(address) or True)
    return asked


def test_without_a_desktop_it_says_the_newest_page(opened):
    assert invoke(app, ["open"]).stdout == "open results/second/report.html in a browser\n"
    assert opened == []


def test_on_a_desktop_it_opens_the_page(opened, tmp_path, monkeypatch):
    monkeypatch.setenv("WAYLAND_DISPLAY", "wayland-0")
    assert invoke(app, ["open", "results/first"]).stdout == "results/first/report.html is opened in the browser\n"
    assert opened == [(tmp_path / "results/first/report.html").as_uri()]


@pytest.mark.parametrize(
    ("environment", "platform", "has"),
    [
        ({}, "linux", False),
        ({"DISPLAY": ":0"}, "linux", True),
        ({"DISPLAY": ""}, "linux", False),
        ({"DISPLAY": ":0", "CI": "true"}, "linux", False),
        ({}, "darwin", True),
        ({}, "win32", True),
        ({"CI": "1"}, "win32", False),
    ],
)
def test_what_a_desktop_is(environment, platform, has):
    assert opening.has_desktop(environment, platform) is has


def test_a_folder_without_a_page_is_refused(opened, tmp_path, monkeypatch):
    with pytest.raises(AdcsError, match=r"^nothing/report\.html does not exist: give the folder of a run's results$"):
        raise invoke(app, ["open", "nothing"]).exception
    monkeypatch.chdir(tmp_path / "results")
    with pytest.raises(AdcsError, match=r"there is no results/\*/report\.html here: run a system first"):
        raise invoke(app, ["open"]).exception
