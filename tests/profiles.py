"""How much is tried: a handful in `make test`, thousands in `make campaign`.

One place knows all numbers: hypothesis' examples, mutants, random robots and scenes, seeds. `make
test` tries the same cases each time; `make campaign` draws a fresh seed, prints it, and takes it
back as `make campaign SEED=...`.
"""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
import pytest
from hypothesis import Phase, settings

# Explaining a failure traces every line, which takes minutes in numerical code.
_PHASES = (Phase.explicit, Phase.generate, Phase.shrink)


@dataclass(frozen=True)
class Profile:
    """How many cases there are and where their random numbers come from.

    Attributes:
        name: "test" or "campaign".
        factor: Cases of the campaign for one of `make test`.
        seed: Added to the seed of each test; 0 in `make test`.
    """

    name: str
    factor: int
    seed: int

    @property
    def is_campaign(self) -> bool:
        return self.name == "campaign"


def _profile() -> Profile:
    name = os.environ.get("WAYPROOF_PROFILE", "test")
    factors = {"test": 1, "campaign": int(os.environ.get("WAYPROOF_FACTOR", "40"))}
    if name not in factors:
        message = f"WAYPROOF_PROFILE is {name!r}; profiles: {sorted(factors)}"
        raise ValueError(message)
    seed = int(os.environ.get("WAYPROOF_SEED", "0")) if name == "campaign" else 0
    return Profile(name, factors[name], seed)


PROFILE = _profile()


def num_cases(test: int, campaign: int | None = None) -> int:
    """Return how many cases to try.

    Args:
        test: In `make test`: a handful.
        campaign: In `make campaign`, 40 times as many by default.
    """
    if not PROFILE.is_campaign:
        return test
    return test * PROFILE.factor if campaign is None else campaign


def seeds(test: int, campaign: int | None = None) -> range:
    """Return seeds, one a case: 0, 1, ... in `make test`, fresh ones in `make campaign`."""
    return range(PROFILE.seed, PROFILE.seed + num_cases(test, campaign))


def pairs[A, B](first: Sequence[A], second: Sequence[B]) -> list[tuple[A, B]]:
    """Return each of both in some pair: as few as there can be, in `make campaign` all of them."""
    if PROFILE.is_campaign:
        return list(product(first, second))
    count = max(len(first), len(second))
    return [(first[i % len(first)], second[i % len(second)]) for i in range(count)]


def rng_of(seed: int) -> np.random.Generator:
    """Return random numbers: always the same in `make test`, fresh ones in `make campaign`."""
    return np.random.default_rng([seed, PROFILE.seed] if PROFILE.is_campaign else seed)


# What the reasons of tests begin with that `make test` leaves out.
ONLY_CAMPAIGN = "only in the campaign"


def only_campaign(why: str) -> pytest.MarkDecorator:
    """Return the mark of a test that `make test` leaves to `make campaign`, and why."""
    return pytest.mark.skipif(not PROFILE.is_campaign, reason=f"{ONLY_CAMPAIGN}: {why}")


def load_hypothesis_profile() -> None:
    """Let hypothesis try as many examples as the profile says, without a clock."""
    settings.register_profile(
        PROFILE.name,
        derandomize=not PROFILE.is_campaign,
        deadline=None,
        database=None,
        max_examples=num_cases(6),
        phases=_PHASES,
        print_blob=PROFILE.is_campaign,
    )
    settings.load_profile(PROFILE.name)
