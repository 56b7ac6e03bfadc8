"""Arguments of sin and cos next to multiples of a quarter turn, where all but the last bits cancel."""

from collections.abc import Iterator
from functools import cache

import mpmath as mp
import numpy as np
from elementary import Floats

BITS = 1300  # of pi: 1024 of the largest double, twice its precision, and room


@cache
def near_quarter_turns(per_binade: int = 4) -> Floats:
    """In every binade from 1 on the doubles nearest to multiples of pi/2, by continued fractions.

    If m 2^e is near n pi/2, then n/m is near 2^e / (pi/2), and its best approximations are convergents: of those whose
    denominator has at most 53 bits the last ones, and their multiples.
    """
    found = []
    with mp.workprec(BITS):
        two_over_pi = int(mp.floor(mp.ldexp(2 / mp.pi, BITS)))
    for exponent in range(-52, 972):
        numerator = two_over_pi << exponent if exponent >= 0 else two_over_pi >> -exponent
        denominators = [m for m in _denominators(numerator, 1 << BITS) if m < 2**53]
        for m in denominators[-per_binade:]:
            factor = -(-(2**52) // m)  # brings it to 53 bits
            if m > 1 and factor * m < 2**53:
                found.append(np.ldexp(float(factor * m), exponent))
    return np.array(found)


def _denominators(numerator: int, denominator: int) -> Iterator[int]:
    """The denominators of the convergents of a fraction, below 2^53."""
    before, now = 0, 1
    while denominator and now < 2**53:
        numerator, denominator = denominator, numerator % denominator
        yield now
        if denominator:
            before, now = now, (numerator // denominator) * now + before
