"""Random robots: trees of links on joints of all kinds, with joints that follow others.

A robot is a document that can be written down, cut and written as a URDF: `links` with shapes and
inertias, `joints` with parent and child. Lengths are drawn about a `size` from 1 mm to 100 m.
"""

from typing import Any

import numpy as np

from tests.adversary.draws.shapes import obj_text, random_shape

type Document = dict[str, Any]

SCALARS = ("revolute", "continuous", "prismatic")
KINDS = (*SCALARS, "planar", "floating", "fixed")


def random_robot(rng: np.random.Generator, **wanted: Any) -> Document:
    """Return a robot of one to six links beside its base.

    Args:
        rng: Random numbers.
        wanted: `size` [m], `links` (how many), `kinds` of joints, `mimics` (share of joints that
            follow), `shapes` (kinds), `inertias` (whether links weigh something).
    """
    size = wanted.get("size") or float(10.0 ** rng.choice([-3, -1, 0, 0, 0, 1, 2]))
    count = wanted.get("links") or int(rng.integers(1, 7))
    kinds = wanted.get("kinds") or KINDS
    links = [_link(rng, "base", size, wanted)]
    joints: list[Document] = []
    for i in range(count):
        parent = links[-1] if rng.random() < 0.75 else links[int(rng.integers(len(links)))]
        links.append(_link(rng, f"l{i}", size, wanted))
        joints.append(_joint(rng, i, (parent["name"], f"l{i}"), (size, kinds)))
    if all(joint["type"] == "fixed" for joint in joints):
        joints[0]["type"] = "revolute"
    _follow(rng, joints, wanted.get("mimics", 0.25))
    return {"size": size, "links": links, "joints": joints}


def _link(rng: np.random.Generator, name: str, size: float, wanted: Document) -> Document:
    count = int(rng.choice([0, 1, 1, 1, 2])) if name != "base" else int(rng.choice([0, 1]))
    kinds = {"kinds": wanted["shapes"]} if "shapes" in wanted else {}
    shapes = [
        {
            "shape": random_shape(rng, 0.25 * size, **kinds),
            "xyz": (size * 0.15 * rng.normal(size=3)).tolist(),
            "rpy": _turn(rng),
        }
        for _ in range(count)
    ]
    link: Document = {"name": name, "shapes": shapes}
    if wanted.get("inertias"):
        link["inertia"] = _inertia(rng, size)
    return link


def _turn(rng: np.random.Generator) -> list[float]:
    """Return roll, pitch and yaw: often none, sometimes right angles, else anything."""
    style = rng.random()
    if style < 0.4:
        return [0.0, 0.0, 0.0]
    if style < 0.5:
        return (np.pi / 2 * rng.integers(-2, 3, size=3)).tolist()
    return rng.uniform(-3, 3, size=3).tolist()


def _joint(
    rng: np.random.Generator, i: int, ends: tuple[str, str], how: tuple[float, Any]
) -> Document:
    size, kinds = how
    kind = str(rng.choice(kinds))
    axis = rng.normal(size=3) if rng.random() < 0.6 else np.eye(3)[rng.integers(3)]
    reach = size if kind == "prismatic" else float(rng.uniform(0.5, 3.1))
    is_put = kind != "floating" or rng.random() < 0.2
    middle = float(rng.uniform(-0.3, 0.3)) * reach
    return {
        "name": f"j{i}",
        "type": kind,
        "parent": ends[0],
        "child": ends[1],
        "xyz": (size * 0.5 * rng.normal(size=3)).tolist() if is_put else [0.0, 0.0, 0.0],
        "rpy": _turn(rng) if is_put else [0.0, 0.0, 0.0],
        "axis": [0.0, 0.0, 1.0] if kind == "planar" else axis.tolist(),
        "lower": middle - reach,
        "upper": middle + reach,
        "velocity": (size if kind == "prismatic" else 1.0) * float(10 ** rng.uniform(-1, 1)),
        "effort": 1e9,
    }


def _follow(rng: np.random.Generator, joints: list[Document], share: float) -> None:
    """Let some joints of one coordinate follow others, also such as follow themselves."""
    scalar = [joint for joint in joints if joint["type"] in SCALARS]
    for i, joint in enumerate(scalar[1:], start=1):
        if rng.random() >= share:
            continue
        leader = scalar[int(rng.integers(i))]
        ratio = (joint["upper"] - joint["lower"]) / (leader["upper"] - leader["lower"])
        multiplier = float(rng.choice([-1, 1]) * ratio * 10 ** rng.uniform(-0.7, 0.0))
        middles = [(j["upper"] + j["lower"]) / 2 for j in (leader, joint)]
        offset = middles[1] - multiplier * middles[0]
        joint["mimic"] = {"joint": leader["name"], "multiplier": multiplier, "offset": offset}
        # What follows within its own limits as long as its leader keeps its own.
        least = abs(multiplier) * leader["velocity"] * float(10 ** rng.uniform(0, 0.5))
        joint["velocity"] = max(joint["velocity"], least)


def _inertia(rng: np.random.Generator, size: float) -> Document:
    """Return mass, centre and inertia that a cloud of points has, so that a body can have them."""
    points, mass = 0.1 * size * rng.normal(size=(6, 3)), float(10 ** rng.uniform(-1, 1))
    square = points.T @ points / 6 * mass
    about = np.trace(square) * np.eye(3) - square
    matrix = [about[0, 0], about[0, 1], about[0, 2], about[1, 1], about[1, 2], about[2, 2]]
    return {
        "mass": mass,
        "xyz": (0.2 * size * rng.normal(size=3)).tolist(),
        "rpy": _turn(rng),
        "matrix": [float(x) for x in matrix],
    }


def _words(numbers: Any) -> str:
    return " ".join(repr(float(x)) for x in numbers)


def _origin(part: Document) -> str:
    return f'<origin xyz="{_words(part["xyz"])}" rpy="{_words(part["rpy"])}"/>'


def _geometry(shape: Document, files: dict[str, str]) -> str:
    ((kind, size),) = shape.items()
    match kind:
        case "box":
            return f'<box size="{_words(size)}"/>'
        case "sphere":
            return f'<sphere radius="{size!r}"/>'
        case "cylinder" | "capsule":
            tag = kind if kind == "cylinder" else "drake:capsule"
            return f'<{tag} radius="{size["radius"]!r}" length="{size["length"]!r}"/>'
        case "ellipsoid":
            a, b, c = size
            return f'<drake:ellipsoid a="{a!r}" b="{b!r}" c="{c!r}"/>'
        case _:
            name = f"hull{len(files)}.obj"
            files[name] = obj_text(np.array(size["points"]))
            return f'<mesh filename="{name}"/>'


def _link_text(link: Document, files: dict[str, str]) -> str:
    parts = [
        f"<collision>{_origin(p)}<geometry>{_geometry(p['shape'], files)}</geometry></collision>"
        for p in link["shapes"]
    ]
    if "inertia" in link:
        weight = link["inertia"]
        names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        values = " ".join(f'{n}="{x!r}"' for n, x in zip(names, weight["matrix"], strict=True))
        mass = f'<mass value="{weight["mass"]!r}"/>'
        parts.append(f"<inertial>{_origin(weight)}{mass}<inertia {values}/></inertial>")
    return f'<link name="{link["name"]}">{"".join(parts)}</link>'


def _joint_text(joint: Document) -> str:
    kind = joint["type"]
    parts = [
        f'<parent link="{joint["parent"]}"/><child link="{joint["child"]}"/>',
        _origin(joint),
    ]
    if kind in {*SCALARS, "planar"}:
        parts.append(f'<axis xyz="{_words(joint["axis"])}"/>')
    if kind in SCALARS:
        bounds = ["velocity", "effort"] + (["lower", "upper"] if kind != "continuous" else [])
        values = " ".join(f'{name}="{joint[name]!r}"' for name in bounds)
        parts.append(f"<limit {values}/>")
    if "mimic" in joint:
        parts.append("<mimic " + " ".join(f'{k}="{v}"' for k, v in joint["mimic"].items()) + "/>")
    return f'<joint name="{joint["name"]}" type="{kind}">{"".join(parts)}</joint>'


def urdf_files(robot: Document) -> dict[str, str]:
    """Return the robot's files by name: `robot.urdf` and the meshes that it names."""
    files: dict[str, str] = {}
    links = "\n".join(_link_text(link, files) for link in robot["links"])
    joints = "\n".join(_joint_text(joint) for joint in robot["joints"])
    head = '<robot name="m" xmlns:drake="http://drake.mit.edu">'
    files["robot.urdf"] = f"{head}\n{links}\n{joints}\n</robot>\n"
    return files
