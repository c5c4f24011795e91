"""Attack from a shell, and the same attacks for the tests.

    python -m tests.adversary.run --kind clearance --seed 17             # one case again
    python -m tests.adversary.run --kind all --seed 0 --cases 500        # many
    python -m tests.adversary.run --kind clearance --seed 17 --shrink    # cut down, and printed
    python -m tests.adversary.run --case FILE                            # one that was printed
    python -m tests.adversary.run --kind all --cases 500 --log FILE  # goes on where it ended

A log has a line for every block of seeds that is done; the same command with it does the others
and tells of all. It is of one version of the code: begin another after every change.

One integer makes a case again. What is wrong is told with the number of the defect that it is
likely to be, 0 for one that is not known. What is refused though it is kept by far is told too.
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

from tests.adversary import service
from tests.adversary.campaign_log import CampaignLog, blocks
from tests.adversary.cases import Claim, Document, Outcome
from tests.adversary.kinds import KINDS
from tests.adversary.shrink import shrunk

# Claims of one sort that are told in full.
_TOLD = 5


def attack(kind: str, seed: int) -> tuple[Document, Outcome]:
    """Draw a case of a kind and judge it."""
    case = draw(kind, seed)
    return case, judge(case)


def draw(kind: str, seed: int) -> Document:
    """Return the case of a kind that a seed makes."""
    with tempfile.TemporaryDirectory() as folder:
        return KINDS[kind].draw(np.random.default_rng(seed), Path(folder))


def judge(case: Document) -> Outcome:
    """Judge a case in a folder of its own; an exception that is no answer is wrong as well."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            return KINDS[case["kind"]].judge(case, Path(folder))
        except Exception as fault:  # noqa: BLE001  (an answer that is none is a finding)
            where = traceback.extract_tb(fault.__traceback__)[-1]
            said = f"{Path(where.filename).name}:{where.lineno} {fault!r}"
            return Outcome([Claim(type(fault).__name__, said)])


def cut_down(case: Document, what: str) -> Document:
    """Return the case without all that its failure does not need."""
    return shrunk(case, lambda smaller: what in {claim.what for claim in judge(smaller).wrong})


def command(kind: str, seed: int) -> str:
    """Return the command that makes a case again."""
    return f"python -m tests.adversary.run --kind {kind} --seed {seed}"


def _campaign(kinds: list[str], seeds: range, log: Path | None) -> tuple[Outcome, Counter[str]]:
    total = Outcome()
    found: Counter[str] = Counter()
    known = CampaignLog.read(log)
    for kind in kinds:
        spent = 0.0
        for block in blocks(seeds):
            done = known.get(kind, block)
            if done is None:
                begin = time.process_time()
                outcome = _attack_all(kind, block, found)
                done = known.put(kind, block, outcome, time.process_time() - begin)
            else:
                found.update(f"{kind}: {c.what} (#{c.issue})" for c in done.claims)
            total.add(done.outcome)
            spent += done.seconds
        each = spent / max(len(seeds), 1)
        told = f"seeds {seeds.start} to {seeds.stop - 1}, {spent:.1f} s, {each:.3f} s a case"
        print(f"{kind}: {told}", flush=True)
    return total, found


def _attack_all(kind: str, seeds: range, found: Counter[str]) -> Outcome:
    """Attack with some seeds, and tell the first claims of each sort."""
    total = Outcome()
    for number in seeds:
        _, outcome = attack(kind, number)
        total.add(outcome)
        for claim in [*outcome.wrong, *outcome.refused]:
            key = f"{kind}: {claim.what} (#{claim.issue})"
            found[key] += 1
            if found[key] <= _TOLD:
                said = f"{claim.what} (#{claim.issue}): {claim.said}"
                print(f"{command(kind, number)}: {said}", flush=True)
    return total


def _one(case: Document, *, shrink: bool) -> int:
    outcome = judge(case)
    for claim in outcome.wrong:
        print(f"{claim.what} (#{claim.issue}): {claim.said}")
    if shrink and outcome.wrong:
        print(json.dumps(cut_down(case, outcome.wrong[0].what)))
    return 1 if outcome.wrong else 0


def main() -> int:
    """Run what the command line asks for; return 1 if something is wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kind", default="all", choices=["all", *KINDS])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--cases", type=int, default=1)
    parser.add_argument("--shrink", action="store_true")
    parser.add_argument("--case", type=Path)
    parser.add_argument("--log", type=Path)
    options = parser.parse_args()
    try:
        if options.case is not None:
            return _one(json.loads(options.case.read_text()), shrink=options.shrink)
        if options.shrink:
            return _one(draw(options.kind, options.seed), shrink=True)
        kinds = list(KINDS) if options.kind == "all" else [options.kind]
        seeds = range(options.seed, options.seed + options.cases)
        total, found = _campaign(kinds, seeds, options.log)
        print(json.dumps(total.counts, indent=1))
        print(f"{len(total.wrong)} wrong, {len(total.refused)} refused though kept by far")
        for what, count in found.most_common():
            print(f"  {count:5d} {what}")
        return 1 if total.wrong else 0
    finally:
        service.close()


if __name__ == "__main__":
    sys.exit(main())
