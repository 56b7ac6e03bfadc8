"""Runs under two controls with the same noise sequences, compared sequence by sequence."""

from __future__ import annotations

from collections.abc import Iterable


def spread(first: Iterable[float], second: Iterable[float]) -> str:
    """Say between what the ratio of first to second, a value for each sequence, lies."""
    ratios = [a / b for a, b in zip(first, second, strict=True)]
    return f"{min(ratios):.3g} to {max(ratios):.3g} over {len(ratios)} noise sequences"
