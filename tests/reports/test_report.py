from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from lxml import html

from orchestration.results import report
from orchestration.results.plots import Panel, Series
from orchestration.results.report import KeyNumber, Table, format_cell

EVIL = "<script>alert('x')</script> & more"
SUM = "0123456789abcdef" * 4
MANIFEST = {
    "started": "2020-01-01",
    "system": {
        "name": "loop",
        "components": {
            "plant": {"sha256": SUM, "start": {"J_B": [[1.0, 0.0], [0.0, 2.0]], "gain": 0.5}},
            "tracker": {"sha256": "cd34"},
        },
        "connections": [["plant.q", "tracker.q"], ["tracker.q", "law.q"]],
    },
    "settings": {"step": 0.01, "solver": None},
    "runs": [{"label": "first", "seed": 3}, {"label": "second"}],
    "warnings": [],
}


def page(path: Path) -> Any:
    return html.fromstring(path.read_text(encoding="utf-8"))


def text_of(element: Any) -> str:
    return " ".join(element.text_content().split())


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    panels = [
        Panel("Rate", "ω [rad/s]", [Series(EVIL, [0.0, 1.0], [2.0, 3.0])], note="noted", group="Tracking"),
        Panel("Torque", "u [N.m]", [Series("u", [0.0, 1.0], [2.0, 3.0])], group="Control"),
    ]
    tables = [
        Table("Levels", ["error", "value"], [["a", 0.123456], ["b", float("nan")]], group="Tracking"),
        Table(
            "Claims",
            ["claim", "verdict"],
            [["one", "reproduced"], ["two", "not reproduced"], ["three", "reproduced"], [EVIL, "wrong in print"]],
            group="Tracking",
        ),
    ]
    return report.write(
        tmp_path_factory.mktemp("report") / "deep" / "report.html",
        EVIL,
        f"About {EVIL}",
        panels,
        tables,
        MANIFEST,
        key_numbers=[KeyNumber("Settled after", 42.5, "s", "printed: 60 s")],
        command="adcs run x --set 'a=1' && more",
        tally={"reproduced": 2, "not reproduced": 1, "wrong in print": 1},
        tally_note=", as read",
    )


def test_stands_alone(written: Path) -> None:
    tree = page(written)
    assert [link for link in tree.xpath("//@src | //link/@href") if link != "data:,"] == []
    assert written.read_text(encoding="utf-8").count("plotly.js v") == 1
    assert "@import" not in "".join(tree.xpath("//style/text()"))


def test_nothing_given_becomes_markup(written: Path) -> None:
    tree = page(written)
    assert [script for script in tree.xpath("//script/text()") if script.startswith("alert")] == []
    assert text_of(tree.xpath("//h1")[0]) == EVIL
    assert EVIL in text_of(tree.xpath("//p[@class='summary']")[0])
    assert EVIL in [text_of(cell) for cell in tree.xpath("//td")]


def test_plots_carry_their_data(written: Path) -> None:
    payloads = [json.loads(script) for script in page(written).xpath("//script[@type='application/json']/text()")]
    assert [len(payload["data"]) for payload in payloads] == [1, 1]
    assert payloads[0]["data"][0]["name"] == EVIL
    assert payloads[0]["layout"]["yaxis"]["title"]["text"] == "ω [rad/s]"


def test_sections_follow_the_groups_with_verdicts_first(written: Path) -> None:
    tree = page(written)
    assert [text_of(h) for h in tree.xpath("//h2")] == ["Tracking", "Control", "How it was run"]
    captions = [text_of(c) for c in tree.xpath("//section[@id='section-0']//figcaption")]
    assert captions == ["Claims", "Rate", "Levels"]
    assert [a.get("href") for a in tree.xpath("//nav/a")] == ["#section-0", "#section-1", "#run"]


def test_the_count_of_verdicts_is_shown_and_they_are_coloured(written: Path) -> None:
    tree = page(written)
    tally = [text_of(chip) for chip in tree.xpath("//p[@class='tally']/span")]
    assert tally == ["2 reproduced", "1 not reproduced", "1 wrong in print", "as read"]
    assert [chip.get("class") for chip in tree.xpath("//td/span")] == ["chip good", "chip bad", "chip good", "chip odd"]


def test_key_numbers(written: Path) -> None:
    (number,) = page(written).xpath("//div[@class='number']")
    assert text_of(number) == "Settled after 42.5s printed: 60 s"


def test_manifest_is_laid_out(written: Path) -> None:
    run = page(written).xpath("//section[@id='run']")[0]
    assert text_of(run.xpath(".//pre[@class='command']")[0]) == "adcs run x --set 'a=1' && more"
    facts = [(text_of(d.xpath("./dt")[0]), text_of(d.xpath("./dd")[0])) for d in run.xpath(".//dl/div")]
    assert facts == [("started", "2020-01-01"), ("warnings", report.ABSENT)]
    tables = {
        text_of(details.xpath("./summary")[0]): [
            [text_of(cell) for cell in row.xpath("./*")] for row in details.xpath(".//tr")
        ]
        for details in run.xpath(".//details[not(@class)]")
    }
    assert tables == {
        "system": [["name", "value"], ["name", "loop"]],
        "system: components": [
            ["name", "sha256", "start"],
            ["plant", "0123456789ab", "J_B = 1, 0, 0, 2, gain = 0.5"],
            ["tracker", "cd34", report.ABSENT],
        ],
        "system: connections": [["from", "to"], ["plant.q", "tracker.q"], ["tracker.q", "law.q"]],
        "settings": [["name", "value"], ["step", "0.01"], ["solver", report.ABSENT]],
        "runs": [["label", "seed"], ["first", "3"], ["second", report.ABSENT]],
    }
    assert run.xpath(".//td/@title") == [SUM, "cd34"]
    assert json.loads(run.xpath(".//details[@class='long']/pre/text()")[0]) == MANIFEST


def test_bare_page(tmp_path: Path) -> None:
    tree = page(report.write(tmp_path / "r.html", "Title", "", []))
    assert text_of(tree.xpath("//h1")[0]) == "Title"
    assert tree.xpath("//section | //nav/a | //p") == []


def test_arrays_in_the_manifest(tmp_path: Path) -> None:
    path = report.write(tmp_path / "r.html", "t", "", [], manifest={"q": np.array([1.0, 2.0]), "n": np.int64(3)})
    assert json.loads(page(path).xpath("//details[@class='long']/pre/text()")[0]) == {"q": [1.0, 2.0], "n": 3}


def test_light_and_dark_and_print_are_styled(written: Path) -> None:
    style = "".join(page(written).xpath("//style/text()"))
    dark = re.search(r"prefers-color-scheme: dark\) \{\s*:root \{(.*?)\}", style, re.DOTALL)
    light = re.search(r":root \{(.*?)\}", style, re.DOTALL)
    assert dark and light
    assert set(re.findall(r"--[\w-]+:", light[1])) == set(re.findall(r"--[\w-]+:", dark[1]))
    assert "@media print" in style


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (None, report.ABSENT),
        (float("nan"), report.ABSENT),
        ([], report.ABSENT),
        (0.000123456, "0.0001235"),
        (np.float64(2.0), "2"),
        (123456, "123456"),
        (True, "yes"),
        ([1.0, "a"], "1, a"),
        ("text", "text"),
    ],
)
def test_cells(value: Any, shown: str) -> None:
    assert format_cell(value) == shown
