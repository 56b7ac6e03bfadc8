"""A study has one score: the README and its pages tell the one that the terminal and the report show."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from adcs.catalogue import STUDIES
from adcs.library.outcome import tally

ROOT = Path(__file__).parents[2]
PAGES = {
    "deruiter": ["study-deruiter"],
    "six-dof": ["study-six-dof"],
    "thakur": ["study-thakur", "study-thakur-adaptive", "study-thakur-gyro-free"],
    "trigo": ["study-trigo"],
    "velocity-free": ["study-velocity-free"],
}
VERDICTS = {"reproduced": r"(\d+) reproduced", "not reproduced": r"(\d+) not\b", "wrong in print": r"(\d+) wrong"}


def told(text: str) -> dict[str, int]:
    """The counts in a sentence."""
    return {verdict: int(found[1]) for verdict, said in VERDICTS.items() if (found := re.search(said, text))}


def of_page(name: str) -> tuple[int, dict[str, int]]:
    """How many claims a page tells of in its first bold sentence, and their counts."""
    bold = re.search(
        r"\*\*(\d+) \w+[,:](.*?)\*\*", (ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8"), re.DOTALL
    )
    assert bold
    return int(bold[1]), told(bold[2])


def of_readme(study: str) -> dict[str, int]:
    """The counts in the line of a study."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    return told(next(line for line in readme.splitlines() if line.startswith(f"| `adcs study {study}` | a ")))


def test_the_sentence_of_a_page_is_understood() -> None:
    assert told("46 reproduced, 11 not reproduced, 5 wrong in print") == {
        "reproduced": 46,
        "not reproduced": 11,
        "wrong in print": 5,
    }
    assert told("13 reproduced, 3 wrong in print") == {"reproduced": 13, "wrong in print": 3}


@pytest.mark.parametrize("study", STUDIES)
def test_readme_and_pages_tell_the_same(study: str) -> None:
    pages = [of_page(page) for page in PAGES[study]]
    for claims, counts in pages:
        assert claims == sum(counts.values())
    together = {verdict: sum(counts.get(verdict, 0) for _, counts in pages) for verdict in VERDICTS}
    assert of_readme(study) == {verdict: count for verdict, count in together.items() if count}


@pytest.mark.parametrize("study", ["six-dof", "velocity-free"])
def test_they_tell_what_comes_out(study: str) -> None:
    """The quick ones; the others take up to a minute."""
    outcome, _ = STUDIES[study].run(STUDIES[study].choices(), lambda done, text: None)
    assert of_page(PAGES[study][0]) == (len(outcome.scored()), tally(outcome.scored()))
