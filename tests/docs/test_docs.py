"""What the documentation says is so: examples print what stands below them, links lead somewhere, commands exist."""

import contextlib
import io
import re
import shlex
import tomllib
from dataclasses import fields
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

import adcs
from adcs.cli.app import app
from fmus.catalog import components
from tests.invoking import invoke

ROOT = Path(__file__).parents[2]
CONTRIBUTING = ROOT / "CONTRIBUTING.md"  # its examples are of a component that is not built here
PAGES = [ROOT / "README.md", ROOT / "CHANGELOG.md", CONTRIBUTING, *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"\]\(([^)\s]+)\)")


def named(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def blocks(page: Path) -> list[tuple[str, str]]:
    """Language and content of the fenced blocks."""
    return [(match[1], match[2]) for match in BLOCK.finditer(page.read_text(encoding="utf-8"))]


def anchors(page: Path) -> set[str]:
    """The anchors that headings get where Markdown is shown."""
    text = BLOCK.sub("", page.read_text(encoding="utf-8"))
    headings = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def has_examples(page: Path) -> bool:
    return page != CONTRIBUTING and any(kind == "python" for kind, _ in blocks(page))


@pytest.mark.parametrize("page", [page for page in PAGES if has_examples(page)], ids=named)
def test_python_examples_print_what_stands_below_them(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The examples of a page belong together; a block of text after one is what it prints."""
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {"__name__": "example"}
    compared = 0
    for (kind, code), (next_kind, expected) in pairwise([*blocks(page), ("", "")]):
        if kind != "python":
            continue
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(code, named(page), "exec"), names)
        if next_kind == "text":
            assert printed.getvalue() == expected
            compared += 1
    assert compared > 0


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_links_lead_somewhere(page: Path) -> None:
    for target in LINK.findall(BLOCK.sub("", page.read_text(encoding="utf-8"))):
        assert "://" not in target, f"{target}: the documentation speaks of this project only"
        path, _, anchor = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        assert file.exists(), target
        if anchor:
            assert anchor in anchors(file), target


def test_every_page_can_be_reached_from_the_readme() -> None:
    reached, waiting = set(), [ROOT / "README.md"]
    while waiting:
        page = waiting.pop()
        reached.add(page)
        links = {(page.parent / link.partition("#")[0]).resolve() for link in LINK.findall(page.read_text("utf-8"))}
        waiting += [link for link in links if link in PAGES and link not in reached]
    assert reached == set(PAGES)


def adcs_commands(page: Path) -> list[str]:
    """Commands in blocks of shell, and between backticks."""
    text = page.read_text(encoding="utf-8")
    shell = [line for kind, code in blocks(page) if kind in ("sh", "console") for line in code.splitlines()]
    inline = re.findall(r"`([^`\n]+)`", BLOCK.sub("", text))
    found = [re.sub(r"^\$ |\s+#.*$", "", line) for line in (*shell, *inline)]
    return [line for line in found if re.match(r"adcs [a-z]", line)]


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_commands_and_their_options_exist(page: Path) -> None:
    for line in adcs_commands(page):
        _, name, *words = shlex.split(line)
        assert name in list(app), line
        options = {option for argument in app[name].assemble_argument_collection() for option in argument.names}
        for word in words:
            if word.startswith("--") and word != "--help":
                assert word in options, line


def test_every_field_of_an_entry_stands_in_the_page_on_own_systems() -> None:
    page = (ROOT / "docs" / "your-own.md").read_text(encoding="utf-8")
    told = [name for row in re.findall(r"^\| (`.*?) \|", page, re.MULTILINE) for name in re.findall(r"`(\w+)`", row)]
    assert told == [field.name for field in fields(adcs.SystemEntry)]


def test_the_project_is_described_in_the_same_words_everywhere() -> None:
    described = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["description"]
    assert (ROOT / "README.md").read_text(encoding="utf-8").startswith(f"# adcs-fmus\n\n{described}: ")
    assert f'title: "adcs-fmus: {described[0].lower()}{described[1:]}"' in (ROOT / "CITATION.cff").read_text()
    assert str(adcs.__doc__).startswith(f"{described}.\n")
    assert invoke(app, ["--help"]).stdout.count(f"{described}.") == 1


def test_pictures_are_small() -> None:
    pictures = list((ROOT / "docs" / "images").iterdir())
    assert pictures
    for picture in pictures:
        assert picture.stat().st_size < 300_000, picture.name


def test_every_component_stands_in_the_list() -> None:
    page = (ROOT / "docs" / "components.md").read_text(encoding="utf-8")
    for component in components():
        header = component.header.relative_to(ROOT).as_posix()
        assert f"| [{component.name}](../{header}) | {component.summary} |" in page, component.name
