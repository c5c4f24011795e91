"""Attack on identity: what differs has another digest, and what is the same gets the same answer.

Files are edited under a scene that is kept, numbers are made that float64 cannot tell apart, and
the same question is asked with the kernel and without.
"""

from pathlib import Path
from typing import Any

import numpy as np

import planning
from tests.adversary import clearance
from tests.adversary.cases import Document, Outcome, Setting, check_of
from tests.adversary.robots import SCALARS

# Without the kernel a proof may take long; then nothing is compared [s].
_PATIENCE = 1.0


def draw(rng: np.random.Generator, folder: Path) -> Document:
    """Return a case of clearance, and what to change in it."""
    case = clearance.draw(rng, folder)
    case["questions"] = case["questions"][:1]
    case["questions"][0].pop("robustness", None)
    number = int(2 ** rng.integers(50, 62)) + int(rng.integers(0, 2))
    edit = str(rng.choice(["shape", "limit"]))
    return {**case, "kind": "identities", "number": number, "edit": edit}


def judge(case: Document, folder: Path) -> Outcome:
    """Ask, edit, and ask again."""
    setting, outcome = Setting.lay_out(case, folder), Outcome()
    outcome.count("asked")
    _numbers(case["number"], outcome)
    (question,) = case["questions"]
    answers = {}
    for kernel in (True, False):
        setting.__dict__["world"] = planning.load_world(
            planning.parse_scene(setting.document), kernel=kernel
        )
        answers[kernel] = setting.ask(question, _PATIENCE)
    if not any(isinstance(answer, Exception) for answer in answers.values()):
        _alike(answers[True][0], answers[False][0], outcome)
    before = setting.world.digest
    edited = _edited(case)
    if edited is None:
        return outcome
    again = Setting.lay_out(edited, folder)
    if again.world.digest == before:
        outcome.blame(
            "digest", f"the same after an edit of a {case['edit']} in the robot's file", 1
        )
    return outcome


def _numbers(number: int, outcome: Outcome) -> None:
    """Two seeds that differ make two problems."""
    goal = planning.ConfigurationGoal("home")
    problems = [planning.PlanningProblem("r", goal, seed=number + i) for i in (0, 1)]
    if problems[0] == problems[1]:
        outcome.blame("digest", f"the same of seeds {number} and {number + 1}", 14)


def _alike(with_kernel: Any, without: Any, outcome: Outcome) -> None:
    """With and without the kernel the verdict is the same; whether the bytes are is counted."""
    if with_kernel.proven != without.proven:
        said = (
            f"{with_kernel.proven} {with_kernel.failed}, without {without.proven} {without.failed}"
        )
        outcome.blame("kernel", said)
    outcome.count("verdicts alike", with_kernel.proven == without.proven)
    if all(check_of(certificate, "clearance").passed for certificate in (with_kernel, without)):
        outcome.count("clearance proven twice")
        outcome.count("certificates of the same bytes", with_kernel == without)


def _edited(case: Document) -> Document | None:
    """Return the case with one number of the robot's file changed; None if there is none."""
    joints = [dict(joint) for joint in case["robot"]["joints"]]
    links = [
        {**link, "shapes": [dict(s) for s in link["shapes"]]} for link in case["robot"]["links"]
    ]
    if case["edit"] == "limit":
        found = next((joint for joint in joints if joint["type"] in SCALARS), None)
        if found is not None:
            found["velocity"] /= 4
    else:
        found = next((shape for link in links for shape in link["shapes"]), None)
        if found is not None:
            found["xyz"] = [2 * x + 1e-3 for x in found["xyz"]]
    return (
        None
        if found is None
        else {**case, "robot": {**case["robot"], "joints": joints, "links": links}}
    )
