"""Attack on identity: what differs has another digest, and what is the same gets the same answer.

Files are edited under a scene that is kept, numbers are made that float64 cannot tell apart, and
the same question is asked with the kernel and without.
"""

import copy
from pathlib import Path
from typing import Any

import numpy as np

import planning
from tests.adversary.attacks import clearance
from tests.adversary.cases import Document, Outcome, Setting, check_of
from tests.adversary.draws.robots import SCALARS

# Without the kernel a proof may take long; then nothing is compared [s].
_PATIENCE = 1.0


def draw(rng: np.random.Generator, folder: Path) -> Document:
    """Return a case of clearance, and what to change in it."""
    case = clearance.draw(rng, folder)
    case["questions"] = case["questions"][:1]
    case["questions"][0].pop("robustness", None)
    number = int(2 ** rng.integers(50, 62)) + int(rng.integers(0, 2))
    edit = str(rng.choice(["shape", "limit", "mesh", "mesh of an object"]))
    return {**case, "kind": "digests", "number": number, "edit": edit}


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
    edited = _edited(case)
    if edited is None:
        return outcome
    outcome.count(f"edits of a {case['edit']}")
    again = Setting.lay_out(edited, folder)
    if again.world.digest == setting.world.digest:
        outcome.blame("digest", f"the same after an edit of a {case['edit']}", 1)
    kept = Setting(case, folder)
    kept.__dict__["world"] = planning.load_world(setting.world.scene)
    answer = kept.ask(question, _PATIENCE)
    if not isinstance(answer, Exception) and not isinstance(answers[True], Exception):
        outcome.count("asked of what was kept")
        if answer[0] != answers[True][0]:
            outcome.blame("kept scene", f"another answer after an edit of a {case['edit']}", 1)
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
    """Return the case with one number of one of its files changed; None if there is none."""
    made = copy.deepcopy(case)
    joints = [joint for joint in made["robot"]["joints"] if joint["type"] in SCALARS]
    placed = [shape for link in made["robot"]["links"] for shape in link["shapes"]]
    match case["edit"]:
        case "limit":
            for joint in joints[:1]:
                joint["velocity"] /= 4
        case "shape":
            for part in placed[:1]:
                part["xyz"] = [2 * x + 1e-3 for x in part["xyz"]]
        case _:
            things = made["objects"] if "object" in case["edit"] else placed
            meshes = [part["shape"]["convex"] for part in things if _is_file(part)]
            for mesh in meshes[:1]:
                mesh["points"] = [[1.5 * x for x in point] for point in mesh["points"]]
    return None if made == case else made


def _is_file(part: Document) -> bool:
    """Return whether a shape is a file of its own: an object's is only where it says so."""
    return "convex" in part["shape"] and part.get("as_mesh", "name" not in part)
