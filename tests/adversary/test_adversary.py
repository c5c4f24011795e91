"""An attacker of our own: random robots, scenes and motions, judged by code that shares nothing.

`make test` tries a few cases of every kind, `make campaign` thousands. A failure is cut down and
printed as a case that `python -m tests.adversary.run --case FILE` takes.
"""

import json

import pytest

from tests.adversary import service
from tests.adversary.kinds import KINDS
from tests.adversary.run import command, cut_down, draw, judge
from tests.profiles import PROFILE, num_cases

# Cases in `make test`; in the campaign there are 40 times as many of each, or more.
CASES = {
    "clearance": 3,
    "rates": 8,
    "discontinuities": 6,
    "floats": 6,
    "polynomial_degrees": 6,
    "cars": 6,
    "whole_turns": 6,
    "constraints": 4,
    "checks": 3,
    "torques": 4,
    "formats": 10,
    "digests": 1,
    "plans": 1,
    "http_answers": 2,
    "executions": 2,
    "neighbours": 6,
    "samples": 2,
    "stops": 4,
}
# A case of these takes half a second.
CAMPAIGN = {"clearance": 240, "formats": 560, "plans": 80, "http_answers": 160, "samples": 160}
# Seeds of one test in the campaign.
BLOCK = 20


@pytest.fixture(scope="module", autouse=True)
def stopped():
    yield
    service.close()


def blocks() -> list[tuple[str, range]]:
    """Return the kinds with their seeds, a block each, so that processes share the work."""
    found = []
    for kind, count in CASES.items():
        total = num_cases(count, CAMPAIGN.get(kind))
        for begin in range(0, total, BLOCK):
            first, last = PROFILE.seed + begin, PROFILE.seed + min(begin + BLOCK, total)
            found.append(pytest.param(kind, range(first, last), id=f"{kind}-{begin}"))
    return found


@pytest.mark.campaign
@pytest.mark.parametrize(("kind", "seeds"), blocks())
def test_what_is_said_is_so(kind: str, seeds: range) -> None:
    for seed in seeds:
        case = draw(kind, seed)
        outcome = judge(case)
        if outcome.wrong:
            worst = outcome.wrong[0]
            smaller = cut_down(case, worst.what)
            pytest.fail(f"{command(kind, seed)}\n{worst.what}: {worst.said}\n{json.dumps(smaller)}")


def test_every_kind_is_tried() -> None:
    assert set(CASES) == set(KINDS)
