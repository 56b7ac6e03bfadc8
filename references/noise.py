"""What the sensors draw, written anew: numbers as a function of the names of component and channel, seed and draw."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .observer_pd import Array

Words = NDArray[np.uint64]
State = Callable[[str, ArrayLike, ArrayLike], Words]
"""Where the generator starts, by the stream's name, seed and draw."""

_GAMMA = 0x9E3779B97F4A7C15


def mixed(z: Words) -> Words:
    """The output function of SplitMix64 at the state before z + the golden gamma."""
    z = z + np.uint64(_GAMMA)
    z = (z ^ z >> np.uint64(30)) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ z >> np.uint64(27)) * np.uint64(0x94D049BB133111EB)
    return z ^ z >> np.uint64(31)


def words(x: ArrayLike) -> Words:
    """Integers modulo 2^64, as an array: of numpy's scalars, overflow is a warning."""
    return np.atleast_1d(np.asarray(x, np.int64)).astype(np.uint64)


def key(stream: str) -> Words:
    """The 64-bit FNV-1a hash of `Component` or `Component.channel`."""
    value = 0xCBF29CE484222325
    for byte in stream.encode():
        value = (value ^ byte) * 0x100000001B3 % 2**64
    return np.array([value], np.uint64)


def start(stream: str, seed: ArrayLike, k: ArrayLike) -> Words:
    return mixed(mixed(key(stream) + mixed(words(seed))) + mixed(words(k)))


def uniform(stream: str, seed: ArrayLike, k: ArrayLike, n: int, state: State = start) -> Array:
    """The first n numbers on [0, 1) of each draw, (draws, n)."""
    at = state(stream, seed, k)[:, None] + np.array([i * _GAMMA % 2**64 for i in range(n)], np.uint64)
    return (mixed(at) >> np.uint64(11)).astype(float) / 2**53


def normal(stream: str, seed: ArrayLike, k: ArrayLike, n: int = 3, state: State = start) -> Array:
    """The first n standard normal numbers of each draw, by Box and Muller's method, (draws, n)."""
    u = uniform(stream, seed, k, 2 * n, state)
    return np.asarray(np.sqrt(-2 * np.log(1 - u[:, ::2])) * np.cos(2 * np.pi * u[:, 1::2]))


def directions(stream: str, seed: ArrayLike, k: ArrayLike, skip: int = 1, state: State = start) -> Array:
    """Uniform on the sphere, by Marsaglia's method, after `skip` other numbers of the same draw; (draws, 3)."""
    pairs = uniform(stream, seed, k, skip + 128, state)[:, skip:] * 2 - 1
    x, y = pairs[:, ::2], pairs[:, 1::2]
    first = np.argmax(x * x + y * y < 1, axis=1)  # a pair is refused with the probability 1 - pi/4
    x, y = (np.take_along_axis(v, first[:, None], 1)[:, 0] for v in (x, y))
    s = x * x + y * y
    r = 2 * np.sqrt(1 - s)
    return np.stack([x * r, y * r, 1 - 2 * s], axis=1)
