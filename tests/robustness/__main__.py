"""`python -m tests.robustness [WORD ...]`: all rows, or those whose description has one of the words."""

from __future__ import annotations

import importlib
import pkgutil
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.robustness import Attack, rows

REPORT = Path("results/robustness.md")
_HEAD = ["| attacked by | tries | survived | that is |", "|---|---:|---:|---|"]


def main(words: list[str]) -> int:
    """Print the table, and what was not survived; return how many tries that were."""
    sys.path.insert(0, str(Path(__file__).parents[1] / "orchestration"))  # whose mocks are used
    names = sorted(module.name for module in pkgutil.iter_modules(rows.__path__))
    attacks: list[Attack] = []
    for name in names:
        attacks += importlib.import_module(f"tests.robustness.rows.{name}").ATTACKS
    lines, failed = list(_HEAD), 0
    for attack in attacks:
        if words and not any(word in attack.what for word in words):
            continue
        began = time.monotonic()
        with TemporaryDirectory() as folder:
            outcomes = list(attack.tries(Path(folder)))
        wrong = [outcome for outcome in outcomes if outcome]
        failed += len(wrong)
        lines.append(f"| {attack.what} | {len(outcomes)} | {len(outcomes) - len(wrong)} | {attack.survived} |")
        print(f"{lines[-1]}  ({time.monotonic() - began:.0f} s)", flush=True)
        for text in wrong:
            print(f"    {text}", flush=True)
    REPORT.parent.mkdir(exist_ok=True)
    REPORT.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return failed


if __name__ == "__main__":
    sys.exit(min(main(sys.argv[1:]), 100))
