"""Plans by roboplan, in the interpreter that has it: a line of JSON in, a line of JSON out.

It is run by another Python than the benchmark's and imports nothing of this project. Each problem
is planned as roboplan's own example does: IK for a pose (`SimpleIk`), `RRT` with `rrt_connect`,
`PathShortcutter`, `PathParameterizerTOPPRA`. All settings are roboplan's defaults but for those in
the question, `rrt_connect`, the number of nodes, which leaves the end to the time limit, and what
IK may take and how exact it has to be, which is what the referee demands.
"""

import itertools
import json
import os
import sys
import tempfile
import time
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any

_PARTS = ("core", "rrt", "simple_ik", "toppra")
_GROUP = "planned"
_MAX_NODES = 1_000_000
# The referee's tolerance of a pose is 1e-4 in each entry of its matrix.
_POSE_TOLERANCE = 5e-5


def main() -> None:
    """Say who is there, then answer questions until there are no more."""
    # What a library prints goes to the errors: answers stay whole lines.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    try:
        modules = [import_module(f"roboplan.{part}") for part in _PARTS]
    except ImportError as fault:
        _say(answers, {"missing": str(fault)})
        return
    _say(answers, {"name": "roboplan", "version": version("roboplan")})
    for line in sys.stdin:
        _say(answers, _answer(modules, json.loads(line)))


def _say(answers: Any, message: dict[str, Any]) -> None:
    answers.write(json.dumps(message) + "\n")
    answers.flush()


def _answer(modules: Any, asked: dict[str, Any]) -> dict[str, Any]:
    core, rrt, simple_ik, toppra = modules
    began = time.perf_counter()
    scene = _scene(core, asked)
    told: dict[str, Any] = {"load_ms": 1e3 * (time.perf_counter() - began)}
    began, cpu = time.perf_counter(), time.process_time()
    try:
        goal = asked["goal"] or _inverse(core, simple_ik, scene, asked)
        path = _path(core, rrt, scene, asked, goal)
        path = core.PathShortcutter(
            scene,
            core.PathShortcuttingOptions(group_name=_GROUP, max_step_size=asked["step"]),
        ).shortcut(path)
        options = toppra.TOPPRAOptions()
        options.max_adaptive_step_size = min(options.max_adaptive_step_size, asked["step"])
        timed = toppra.PathParameterizerTOPPRA(scene, _GROUP).generate(path, options)
        told["fault"] = ""
    except RuntimeError as fault:
        timed, told["fault"] = None, str(fault) or type(fault).__name__
    told["wall_ms"] = 1e3 * (time.perf_counter() - began)
    told["cpu_ms"] = 1e3 * (time.process_time() - cpu)
    if timed is not None:
        told["times"] = list(timed.times)
        told["positions"] = [list(map(float, q)) for q in timed.positions]
        told["velocities"] = [list(map(float, v)) for v in timed.velocities]
    return told


def _scene(core: Any, asked: dict[str, Any]) -> Any:
    urdf = Path(asked["urdf"])
    scene = core.Scene("problem", core.loadUrdfSceneDescription(urdf, [urdf.parent]))
    scene.importSrdf(Path(asked["srdf"]).read_text("utf-8"))
    scene.importJointLimitsFromConfig(_limits(core, asked))
    scene.addGroup(_GROUP, asked["joints"])
    for thing in asked["obstacles"]:
        _add(core, scene, thing)
    # As in the referee's model: what does not move is not checked against what does not move.
    names = [thing["name"] for thing in asked["obstacles"]]
    fixed = [*itertools.combinations(names, 2), *((name, asked["root"]) for name in names)]
    if fixed:
        scene.setCollisions(fixed, False)  # noqa: FBT003
    scene.setRngSeed(asked["seed"])
    return scene


def _limits(core: Any, asked: dict[str, Any]) -> Any:
    rows = zip(asked["joints"], asked["velocity"], asked["acceleration"], strict=True)
    limits = {
        joint: {"max_velocity": [velocity], "max_acceleration": [acceleration]}
        for joint, velocity, acceleration in rows
    }
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
        file.write(json.dumps({"joint_limits": limits}))  # JSON is YAML
        file.flush()
        return core.loadJointLimitsConfig(file.name)


def _add(core: Any, scene: Any, thing: dict[str, Any]) -> None:
    import numpy as np  # noqa: PLC0415  (roboplan brings it)

    pose, colour = np.asfortranarray(np.array(thing["pose"])), np.ones(4)
    name, dims = thing["name"], thing["dims"]
    if thing["kind"] == "box":
        scene.addBoxGeometry(name, "universe", core.Box(*dims), pose, colour)
    elif thing["kind"] == "cylinder":
        length, radius = dims
        scene.addCylinderGeometry(name, "universe", core.Cylinder(radius, length), pose, colour)
    else:
        scene.addSphereGeometry(name, "universe", core.Sphere(*dims), pose, colour)


def _inverse(core: Any, simple_ik: Any, scene: Any, asked: dict[str, Any]) -> list[float]:
    import numpy as np  # noqa: PLC0415

    options = simple_ik.SimpleIkOptions(
        group_name=_GROUP,
        max_time=asked["seconds"],
        max_restarts=_MAX_NODES,
        max_linear_error_norm=_POSE_TOLERANCE,
        max_angular_error_norm=_POSE_TOLERANCE,
    )
    pose = np.asfortranarray(np.array(asked["pose"]))
    target = core.CartesianConfiguration("universe", asked["tool"], pose)
    solver = simple_ik.SimpleIk(scene, options)
    solver.setRngSeed(asked["seed"])
    start = core.JointConfiguration(asked["joints"], np.array(asked["start"]))
    found = core.JointConfiguration()
    if not solver.solveIk(target, start, found):
        message = "no free configuration was found for the pose"
        raise RuntimeError(message)
    return [float(number) for number in found.positions]


def _path(core: Any, rrt: Any, scene: Any, asked: dict[str, Any], goal: list[float]) -> Any:
    import numpy as np  # noqa: PLC0415

    options = rrt.RRTOptions(
        group_name=_GROUP,
        rrt_connect=True,
        max_nodes=_MAX_NODES,
        max_planning_time=asked["seconds"],
        collision_check_step_size=asked["step"],
    )
    planner = rrt.RRT(scene, options)
    planner.setRngSeed(asked["seed"])
    start, end = (
        core.JointConfiguration(asked["joints"], np.array(q)) for q in (asked["start"], goal)
    )
    return planner.plan(start, end)


if __name__ == "__main__":
    main()
