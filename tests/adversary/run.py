"""Attack from a shell: `python -m tests.adversary.run --kind clearance --seed 17 [--cases 100]`.

One integer makes a case again. `--case FILE` takes a case that was printed, `--shrink` cuts a
failing one down, `--kind all` goes through all kinds.
"""

import argparse
import json
import sys
import tempfile
import time
import traceback
from collections import Counter
from pathlib import Path

import numpy as np

from tests.adversary.cases import Document, Outcome
from tests.adversary import service
from tests.adversary.kinds import KINDS


def attack(kind: str, seed: int) -> tuple[Document, Outcome]:
    """Draw a case of a kind and judge it."""
    with tempfile.TemporaryDirectory() as folder:
        case = KINDS[kind].draw(np.random.default_rng(seed), Path(folder))
    return case, judge(case)


def judge(case: Document) -> Outcome:
    """Judge a case, in a folder of its own."""
    with tempfile.TemporaryDirectory() as folder:
        return KINDS[case["kind"]].judge(case, Path(folder))


def main() -> int:
    """Run what the command line asks for; return 1 if something is wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kind", default="all", choices=["all", *KINDS])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--cases", type=int, default=1)
    options = parser.parse_args()
    total = Outcome()
    found: Counter[tuple[str, int]] = Counter()
    for kind in KINDS if options.kind == "all" else [options.kind]:
        begin = time.process_time()
        for seed in range(options.seed, options.seed + options.cases):
            try:
                case, outcome = attack(kind, seed)
            except Exception as fault:
                where = traceback.extract_tb(fault.__traceback__)[-1]
                print(f"--kind {kind} --seed {seed}: {where.filename}:{where.lineno} {fault!r}")
                found[f"{kind}: {type(fault).__name__}", -1] += 1
                continue
            for claim in outcome.wrong:
                key = f"{kind}: {claim.what}", claim.issue
                found[key] += 1
                if found[key] <= 5:
                    print(f"--kind {kind} --seed {seed}: {claim.what} (#{claim.issue}): {claim.said}")
            total.add(outcome)
        print(f"{kind}: {(time.process_time() - begin) / options.cases * 1000:.0f} ms a case")
    service.close()
    print(total.counts)
    print(found)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
