"""The golden set: digests of answers that no change of names and places may change.

`make golden` notes the digests of the answers of this checkout, and once it has noted some compares
with them. Digests are of one machine and one set of versions: they are no part of the project.
"""

import argparse
import hashlib
import json
import sys
import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tests.golden.plans import Request, plans

# What differs between two runs of the same: names of records, and times.
VOLATILE = {"id", "scene", "revision", "timings", "created_at", "started_at", "finished_at", "plan"}
_SAMPLES = ("times", "positions", "velocities", "accelerations")
# No deadline may cut anything short.
_ALLOWED = {"allowed_time": 60.0}
# Drake alone takes a minute for what takes seconds with the kernel.
WITHOUT_KERNEL = ("ur5e_pickup, configuration", "ur5e_pickup, pose", "maze_2d", "parallel_parking")


def main() -> None:
    """Note digests, or compare with those that were noted."""
    parser = argparse.ArgumentParser(prog="make golden", description=__doc__)
    parser.add_argument("file", type=Path, help="where digests are noted")
    parser.add_argument("--drake-only", action="store_true", help="as without the kernel")
    parser.add_argument("--only", default="", help="plans whose names begin so")
    parser.add_argument("--keep", type=Path, help="folder for the answers, to see what differs")
    arguments = parser.parse_args()
    if arguments.drake_only:
        sys.modules["planning.kernel._native"] = None  # pyright: ignore[reportArgumentType]
    wanted = [
        each
        for each in plans()
        if each[0].startswith(arguments.only)
        and (not arguments.drake_only or each[0].startswith(WITHOUT_KERNEL))
    ]
    answers = {name: lasting(answer) for name, answer in _answers(wanted)}
    if arguments.keep:
        arguments.keep.mkdir(parents=True, exist_ok=True)
        for name, answer in answers.items():
            file = arguments.keep / f"{name.replace(': ', ', ')}.json"
            file.write_text(json.dumps(answer, indent=1, sort_keys=True), encoding="utf-8")
    sys.exit(compare(arguments.file, {name: digest_of(each) for name, each in answers.items()}))


def compare(file: Path, digests: dict[str, str]) -> int:
    """Write the digests where there are none; else say which differ, and return how many do."""
    if not file.exists():
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(digests, indent=1), encoding="utf-8")
        print(f"{len(digests)} digests noted in {file}")
        return 0
    noted = json.loads(file.read_text(encoding="utf-8"))
    differing = sorted(name for name in noted if name in digests and noted[name] != digests[name])
    for name in differing:
        print(f"differs: {name}")
    print(f"{len(digests)} answers, {len(differing)} differ from {file}")
    return min(1, len(differing))


def _answers(wanted: list[tuple[str, str, Request]]) -> Iterator[tuple[str, Any]]:
    """Yield every answer to every request about the plans."""
    with tempfile.TemporaryDirectory() as folder, _client(folder) as client:
        scenes: dict[str, str] = {}
        for name, scene, request in wanted:
            if scene not in scenes:
                text = Path("scenes", f"{scene}.scene.yaml").read_bytes()
                headers = {"content-type": "application/yaml"}
                posted = client.post("/v1/scenes", content=text, headers=headers).json()
                scenes[scene] = posted["id"]
                yield f"{scene}, scene", posted
            for what, answer in _answers_about(client, {"scene": scenes[scene], **request}):
                yield f"{name}: {what}", answer


def _answers_about(client: Any, request: Request) -> Iterator[tuple[str, Any]]:
    """Yield what is answered to a plan, and to all that can be asked of its group and motion."""
    job = client.post("/v1/plans?wait=60", json=request).json()
    yield "plan", job
    scene, group, goal = request["scene"], request["group"], request["goal"]
    if goal["type"] in {"pose", "region", "relative"}:
        asked = {"group": group, "goal": goal, "seed": 1, **_ALLOWED}
        yield "ik", client.post(f"/v1/scenes/{scene}/ik", json=asked).json()
    if job.get("state") != "succeeded":
        return
    motion = client.get(f"/v1/plans/{job['id']}/trajectory?period=0.05&polynomial=true").json()
    yield "trajectory", motion
    asked = {"group": group, "configurations": motion["positions"][:5]}
    for call in ("check", "fk"):
        yield call, client.post(f"/v1/scenes/{scene}/{call}", json=asked).json()
    asked = {"group": group, "displacement": {"vector": [0, 0, 0.05]}, **_ALLOWED}
    yield "line", client.post(f"/v1/scenes/{scene}/line", json=asked).json()
    yield "reverse", client.post(f"/v1/plans/{job['id']}/reverse?wait=60").json()
    own = {name: motion[name] for name in _SAMPLES}
    own["polynomial"] = motion["polynomial"]
    asked = {"scene": scene, "group": group, "trajectory": own, **_ALLOWED}
    yield "certify", client.post("/v1/trajectories/certify", json=asked).json()
    asked |= {"time": 0.4 * motion["duration"]}
    yield "stop", client.post("/v1/trajectories/stop", json=asked).json()
    onto = {name: motion[name][len(motion["times"]) // 2 :] for name in _SAMPLES}
    onto["times"] = [time - onto["times"][0] for time in onto["times"]]
    asked["onto"] = onto
    yield "splice", client.post("/v1/trajectories/splice", json=asked).json()
    asked = {"scene": scene, "group": group, "waypoints": job["result"]["path"]}
    asked |= _ALLOWED
    yield "retime", client.post("/v1/trajectories/retime", json=asked).json()


def digest_of(answer: Any) -> str:
    """Return the digest of an answer."""
    text = json.dumps(answer, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def lasting(part: Any) -> Any:
    """Return a part of an answer without what differs between two runs."""
    if isinstance(part, dict):
        return {key: lasting(inner) for key, inner in part.items() if key not in VOLATILE}
    return [lasting(inner) for inner in part] if isinstance(part, list) else part


def _client(folder: str) -> Any:
    from service.app import create_app
    from service.settings import Settings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from starlette.testclient import TestClient
    settings = Settings(engine="inline", data_dir=Path(folder), query_timeout=300)
    return TestClient(create_app(settings))


if __name__ == "__main__":
    main()
