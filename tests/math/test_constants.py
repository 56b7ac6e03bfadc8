"""The constants in src/math are what their comments say, recomputed with mpmath."""

import re

import mpmath as mp
import pytest

from fmus.paths import SOURCES

HEADERS = {path.name: path.read_text(encoding="utf-8") for path in (SOURCES / "math").glob("*.hpp")}
FITS = [
    (name, recipe, values)
    for name, text in HEADERS.items()
    for recipe, values in re.findall(r"/// mpmath\.(chebyfit\(.*?\))\.\n[^=]*= \{([^}]*)\}", text)
]
HEX = r"0x[\d.a-f]+p[+-]?\d+"


def numbers(text: str) -> list[float]:
    return [float.fromhex(number) for number in re.findall(rf"-?{HEX}", text)]


@pytest.mark.parametrize(("header", "recipe", "values"), FITS, ids=[f"{fit[0]} {i}" for i, fit in enumerate(FITS)])
def test_coefficients_are_those_of_their_recipe(header: str, recipe: str, values: str) -> None:
    with mp.workprec(300):
        fit = eval(recipe, vars(mp))
        assert numbers(values) == [float(c) for c in reversed(fit)]


def test_every_polynomial_has_a_recipe() -> None:
    uses = sum(len(re.findall(r"\bpolynomial\([\w.]+, \w+\)", text)) for text in HEADERS.values())
    assert len(FITS) == uses == 9


def test_parts_of_a_quarter_turn_have_156_bits() -> None:
    body = HEADERS["quarter_turns.hpp"]
    parts = numbers("".join(re.findall(rf"\bn \* {HEX}", body)))
    assert len(parts) == 4
    with mp.workprec(300):
        assert abs(mp.fsum(map(mp.mpf, parts)) - mp.pi / 2) < mp.mpf(2) ** -156
    for part in parts[:3]:
        significand = int(abs(part).as_integer_ratio()[0])
        assert significand.bit_length() <= 33  # times one of 20 bits: 53


def test_two_over_pi_has_its_bits() -> None:
    body = re.search(r"two_over_pi\[\] = \{([^}]*)\}", HEADERS["quarter_turns.hpp"])
    assert body
    words = [int(word, 0) for word in body[1].split(",")]
    assert words[:2] == [0, 0]
    bits = 32 * (len(words) - 2)
    with mp.workprec(bits + 50):
        expected = int(mp.floor(mp.ldexp(2 / mp.pi, bits)))
    assert int("".join(f"{word:08x}" for word in words), 16) == expected


def test_eighth_of_a_turn_in_two_parts() -> None:
    line = re.search(r"double eighth_high.*;", HEADERS["arcus.hpp"])
    assert line
    high, low = numbers(line[0])
    with mp.workprec(200):
        assert abs(mp.mpf(high) + low - mp.pi / 4) < mp.mpf(2) ** -106
    assert high.as_integer_ratio()[0].bit_length() <= 51  # times 3: 53


@pytest.mark.parametrize("divisor", [3, 5])
def test_fractions_of_the_logarithm_have_a_second_part(divisor: int) -> None:
    found = {abs(number) for number in numbers(HEADERS["power.hpp"])}
    with mp.workprec(200):
        high = float(mp.mpf(1) / divisor)
        assert {high, float(abs(mp.mpf(1) / divisor - high))} <= found


def test_logarithm_of_two_in_two_parts() -> None:
    line = re.search(r"double ln2_high.*;", HEADERS["exponential.hpp"])
    assert line
    high, low = numbers(line[0])
    with mp.workprec(200):
        assert abs(mp.mpf(high) + low - mp.log(2)) < mp.mpf(2) ** -97
    assert high.as_integer_ratio()[0].bit_length() <= 42  # times one of 11 bits: 53
