"""What is said of a name that nothing has: what it is like, or some of what there is, in a line of some words."""

import pytest

from fmus.spelling import close, hint, some

GREEK = ("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta")


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("gama", "did you mean gamma?"),
        ("ta", "did you mean eta or zeta or beta?"),
        ("e", "did you mean epsilon or eta?"),
        ("Z", "it has alpha, beta, gamma, delta, epsilon, zeta and 2 more"),
        ("Z" * 1000, "it has alpha, beta, gamma, delta, epsilon, zeta and 2 more"),
    ],
)
def test_a_hint(name, said):
    assert hint(name, GREEK) == said


def test_what_there_is():
    assert some(GREEK[:2]) == "alpha, beta"
    assert some(GREEK[:7]) == "alpha, beta, gamma, delta, epsilon, zeta, eta"  # one more costs no more than to say so
    assert some([]) == "none"
    assert hint("x", ["alpha"], "there is") == "there is alpha"
    assert close("x", ["alpha"]) == ""
