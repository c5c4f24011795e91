"""Hold what a certificate says of distances against the nearest that the judge has seen."""

from functools import cached_property
from typing import Any

import numpy as np

from tests.adversary.cases import Document, Outcome, Setting, check_of
from tests.adversary.judge.distances import Near
from tests.adversary.judge.surroundings import Look, Pair, Seen, Stage
from tests.adversary.judge.unchecked_pairs import declared, overlooked
from tests.adversary.judge.witness_points import bracket

# A margin is kept to a micrometre; rounding is a share of the size [m].
SLACK = 1.2e-6
SHARE = 1e-8
# What is free by more than this, and by this share of the size, should be proven [m].
WIDE = 1e-3


class ClearanceJudge:
    """Judges the answers to one question."""

    def __init__(
        self, setting: Setting, stage: Stage, question: Document, outcome: Outcome
    ) -> None:
        self._setting, self._stage, self._outcome = setting, stage, outcome
        stated = setting.case.get("more", {}).get("margin", 0.0)
        self._motion, self._margin = question["motion"], question.get("margin", stated)
        self._slack = SLACK + SHARE * stage.size

    @cached_property
    def _skip(self) -> set[Pair]:
        return declared(self._setting, self._stage)

    def hold(self, certificate: Any, report: Any) -> None:
        """Hold a certificate, and a report of robustness, against what is so."""
        check = check_of(certificate, "clearance")
        self._outcome.count("clearance proven", check.passed)
        if check.passed:
            self._outcome.wrong += overlooked(self._stage, self._motion, self._skip)
        also = (certificate.time, check.time)
        seen = self._worst(Look(self._margin, self._skip, also=also))
        if seen is None:
            return
        if check.passed:
            self._hold_margin(seen)
            self._hold_numbers(certificate, seen)
        else:
            self._hold_refusal(check, seen)
            self._hold_until(certificate)
        if seen.spare > WIDE:
            self._outcome.count("free by 1 mm")
            self._outcome.count("free by 1 mm, not proven", not check.passed)
        if report.robustness is not None and certificate.proven:
            self._hold_robustness(report.robustness)

    def _worst(self, look: Look) -> Seen | None:
        return self._stage.worst(self._motion, look)

    def _hold_margin(self, seen: Seen) -> None:
        if self._is_broken(seen):
            told = f"proven with {self._told(seen)}, margin {self._margin:.9g} m"
            is_neighbours = frozenset(seen.near.pair) in self._stage.unchecked
            self._outcome.blame("clearance", told, 6 if is_neighbours else self._defect)

    def _hold_refusal(self, check: Any, seen: Seen) -> None:
        # Among many pairs not all distances are measured: then and there they are.
        look = Look(self._margin, self._skip, also=(check.time,), count=1, rounds=0)
        there = self._worst(look)
        least = min(seen.spare, np.inf if there is None else there.spare)
        if least > max(WIDE, 1e-3 * self._stage.size):
            said = (
                f"{check.where} {check.value:.6g} +- {check.resolution:.3g} m at {check.time:.6g} s"
            )
            told = f"refused for {said}, but {self._told(seen)}, margin {self._margin:.9g} m"
            self._outcome.blame("refused", told, self._defect)

    def _hold_numbers(self, certificate: Any, seen: Seen) -> None:
        """Hold what is said of the smallest distance, which is not that with least to spare.

        It is that of pairs which the motion moves.
        """
        fixed = self._stage.fixed
        look = Look(None, self._skip | fixed, also=(certificate.time,))
        is_other = self._margin or self._stage.by_pair or frozenset(seen.near.pair) in fixed
        least = self._worst(look) if is_other else seen
        slack = 2e-7 + 10 * SHARE * self._stage.size
        if least is None:
            return
        seen_there = getattr(certificate, "observed_clearance", certificate.min_clearance)
        check = check_of(certificate, "clearance")
        bound = certificate.min_clearance
        if not hasattr(certificate, "observed_clearance"):
            bound -= check.resolution
        told = f"said of {certificate.pair} at {certificate.time:.6g} s, but {self._told(least)}"
        if bound > least.distance + slack and confirmed(least.near) < np.inf:
            self._outcome.blame("least clearance", f"{bound:.9g} m {told}", self._defect or 15)
        if certificate.min_clearance > 2 * max(least.distance, 0) + 1e-3 * self._stage.size:
            text = f"{certificate.min_clearance:.6g} m {told}"
            self._outcome.blame("min_clearance", text, self._defect or 15)
        there = self._stage.at(self._motion, certificate.time, certificate.pair)
        if np.isfinite(there) and abs(there - seen_there) > slack + 1e-5 * abs(there):
            text = f"{seen_there:.9g} m {told}; then and there {there:.9g} m"
            self._outcome.blame("seen clearance", text, self._defect)

    def _hold_until(self, certificate: Any) -> None:
        until = certificate.proven_until
        seen = self._worst(Look(self._margin, self._skip, until=until)) if until > 0 else None
        if seen is not None and self._is_broken(seen):
            told = f"until {until:.6g} s, but {self._told(seen)}, margin {self._margin:.9g} m"
            self._outcome.blame("proven_until", told, self._defect)

    def _hold_robustness(self, robustness: Any) -> None:
        """Displace every obstacle by as much as is allowed, each in a direction of its own.

        Pairs that the motion does not move are not its matter.
        """
        allowed = robustness.obstacle_displacement
        if not (np.isfinite(allowed) and allowed > 0):
            return
        rng = np.random.default_rng(0)
        moved = self._stage.displaced(rng, allowed)
        seen = moved.worst(
            self._motion, Look(self._margin, self._skip | self._stage.fixed, self._stage.own)
        )
        if seen is not None and self._is_broken(seen):
            text = f"obstacles off by {allowed:.9g} m: {self._told(seen)}"
            self._outcome.blame("robustness", text, self._defect)

    def _is_broken(self, seen: Seen) -> bool:
        return seen.spare < -self._slack and confirmed(seen.near) < -self._slack

    def _told(self, seen: Seen) -> str:
        return f"{seen.near.pair} are {seen.distance:.9g} m apart at {seen.time:.6g} s"

    @property
    def _defect(self) -> int:
        """The number of the defect that this is likely to be."""
        return self._stage.suspect


def confirmed(near: Near) -> float:
    """Return the spare of two shapes, or infinity where coal's distance is not confirmed."""
    a, b = near.solids
    if near.distance > 0 and not (a.is_half_space or b.is_half_space):
        _, upper = bracket(a, b, near.index)
        return near.spare if upper <= near.distance + 1e-8 * (a.radius + b.radius) else np.inf
    return near.spare
