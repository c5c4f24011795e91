from collections.abc import Callable, Sequence
from enum import Enum
from typing import Any

import numpy as np

type _Doubles = np.ndarray[Any, np.dtype[np.float64]]
type _Integers = np.ndarray[Any, np.dtype[np.int64]]
type _Flags = np.ndarray[Any, np.dtype[np.bool_]]
type _Verdicts = np.ndarray[Any, np.dtype[np.uint8]]

class ShapeKind(Enum):
    BOX = ...
    SPHERE = ...
    CYLINDER = ...
    CAPSULE = ...
    ELLIPSOID = ...
    HULL = ...
    HALF_SPACE = ...

class JointKind(Enum):
    FIXED = ...
    REVOLUTE = ...
    PRISMATIC = ...
    PLANAR = ...
    FLOATING = ...

class Verdict(Enum):
    FREE = ...
    COLLIDING = ...
    UNSURE = ...

class Outcome(Enum):
    PROVEN = ...
    TOO_NEAR = ...
    UNPROVEN = ...
    STATIC_PAIR = ...

class Freedom(Enum):
    BALL = ...
    CONE = ...
    FREE = ...

class Scene:
    def __init__(self, num_positions: int, num_velocities: int) -> None: ...
    def add_link(
        self,
        parent: int,
        X_PF: _Doubles,
        kind: JointKind,
        axis: _Doubles,
        position: int,
        velocity: int,
    ) -> None: ...
    def add_follower(
        self,
        follower: int,
        leader: int,
        follower_velocity: int,
        leader_velocity: int,
        multiplier: float,
        offset: float,
    ) -> None: ...
    def add_geometry(
        self,
        link: int,
        X_LG: _Doubles,
        kind: ShapeKind,
        size: _Doubles,
        vertices: _Doubles,
        planes: _Doubles,
        outer: _Doubles,
        inner: _Doubles,
        bound: _Doubles,
    ) -> None: ...
    def add_pair(self, a: int, b: int) -> None: ...
    def add_pairs(self, rows: _Integers) -> None: ...
    def with_poses(self, geometries: _Integers, X_LG: _Doubles) -> Scene: ...
    def has_near_pair(self, full: _Doubles, reach: float) -> bool: ...
    def near_geometries(self, full: _Doubles, first: int, reach: float) -> _Integers: ...

class Checker:
    def __init__(
        self,
        scene: Scene,
        positions: _Integers,
        velocities: _Integers,
        state: _Doubles,
        thresholds: _Doubles,
        kernel: str = "",
    ) -> None: ...
    def check(self, qs: _Doubles) -> _Verdicts: ...
    def check_free(self, qs: _Doubles) -> tuple[_Flags, _Integers]: ...
    def check_one(self, q: _Doubles) -> int: ...
    def check_motions(
        self, origins: _Doubles, displacements: _Doubles, resolution: float
    ) -> tuple[_Verdicts, _Integers]: ...
    def check_motion(self, origin: _Doubles, displacement: _Doubles, resolution: float) -> int: ...
    def check_edges(
        self, q0s: _Doubles, q1s: _Doubles, resolution: float, most: int
    ) -> tuple[_Flags, _Integers, int] | None: ...
    def first_edge(
        self, q0s: _Doubles, q1s: _Doubles, resolution: float, most: int
    ) -> tuple[int, bool, int]: ...
    def check_edge(
        self, q0: list[float], q1: list[float], resolution: float
    ) -> tuple[int, int]: ...
    @property
    def undecided_static_pairs(self) -> list[int]: ...
    @property
    def batch_kernel(self) -> str: ...

class RrtConnect:
    def __init__(
        self,
        checker: Checker,
        start: _Doubles,
        goals: _Doubles,
        lower: _Doubles,
        upper: _Doubles,
        max_step: float,
        resolution: float,
        seed: int,
    ) -> None: ...
    def solve(
        self,
        is_free: Callable[[_Doubles, _Doubles], bool],
        report: Callable[[], None],
        max_states: float,
        max_samples: float,
    ) -> bool: ...
    def path(self) -> _Doubles: ...
    @property
    def num_edges_checked(self) -> int: ...
    @property
    def num_states_checked(self) -> int: ...
    @property
    def num_vertices(self) -> int: ...
    @property
    def num_edges(self) -> int: ...
    @property
    def goal_distance(self) -> float: ...

class IkTolerance:
    def __init__(self, box: _Doubles, freedom: Freedom, axis: int, bound: float) -> None: ...

class Chain:
    def __init__(
        self,
        scene: Scene,
        positions: _Integers,
        velocities: _Integers,
        state: _Doubles,
        link: int,
        X_LT: _Doubles,
    ) -> None: ...
    def poses(self, qs: _Doubles) -> _Doubles: ...
    def jacobians(self, qs: _Doubles) -> _Doubles: ...
    def velocity_gradients(self, qs: _Doubles, vs: _Doubles) -> _Doubles: ...
    def solve(
        self,
        seeds: _Doubles,
        target_of: _Integers,
        targets: _Doubles,
        lower: _Doubles,
        upper: _Doubles,
        tolerance: IkTolerance,
        enough: int,
        max_iterations: int,
        kernel: str = "",
    ) -> tuple[_Verdicts, _Doubles, _Integers]: ...

class InverseDynamics:
    def __init__(
        self,
        scene: Scene,
        positions: _Integers,
        velocities: _Integers,
        state: _Doubles,
        inertias: _Doubles,
        rotors: _Doubles,
        gravity: _Doubles,
    ) -> None: ...
    def efforts(self, q: _Doubles, v: _Doubles, vdot: _Doubles) -> _Doubles: ...
    def derivatives(self, q: _Doubles, v: _Doubles, vdot: _Doubles) -> _Doubles: ...

class TorqueSeries:
    def __init__(self, num_positions: int, num_velocities: int, gravity: _Doubles) -> None: ...
    def add_link(
        self,
        parent: int,
        X_PF: _Doubles,
        kind: JointKind,
        axis: _Doubles,
        coordinate: tuple[int, int, float, float],
        drive: tuple[float, float],
        mass: _Doubles,
    ) -> None: ...
    def polynomials(
        self,
        bases: _Doubles,
        coefficients: _Doubles,
        pieces: _Integers,
        middles: _Doubles,
        halves: _Doubles,
        order: int,
        kernel: str = "",
    ) -> tuple[_Doubles, _Doubles]: ...
    def points(
        self,
        bases: _Doubles,
        coefficients: _Doubles,
        pieces: _Integers,
        middles: _Doubles,
        point: _Doubles,
        kernel: str = "",
    ) -> _Doubles: ...

class DistanceQuery:
    def __init__(
        self, scene: Scene, positions: _Integers, velocities: _Integers, state: _Doubles
    ) -> None: ...
    def within(
        self, qs: _Doubles, reach: _Doubles
    ) -> tuple[_Integers, _Integers, _Doubles, _Doubles, _Doubles]: ...

class CurveGrid:
    def __init__(
        self,
        first_points: _Integers,
        num_points: int,
        first: _Doubles,
        second: _Doubles,
        third: _Doubles,
        step: float,
    ) -> None: ...
    def path_velocity(
        self,
        bounds: tuple[_Doubles, _Doubles, _Doubles, _Doubles],
        points: _Doubles,
        low: _Doubles,
        high: _Doubles,
        tolerance: float,
        max_steps: int,
    ) -> tuple[_Doubles, float]: ...
    def step(
        self,
        bounds: tuple[_Doubles, _Doubles, _Doubles, _Doubles],
        points: _Doubles,
        path_velocity: _Doubles,
        layout: tuple[_Integers, _Integers, int],
        model_weights: _Doubles,
        box: tuple[_Doubles, _Doubles, _Doubles],
        rows: tuple[_Integers, _Integers, _Doubles, _Doubles, _Doubles],
        balls: tuple[_Integers, _Integers, _Doubles, _Doubles, _Doubles],
        margins: tuple[_Integers, _Doubles, _Integers, _Doubles, _Doubles, float],
        tolerance: float,
        max_steps: int,
    ) -> tuple[_Doubles, float]: ...

class ClosestApproach:
    @property
    def pair(self) -> int: ...
    @property
    def distance(self) -> float: ...
    @property
    def time(self) -> float: ...

class Proof:
    @property
    def outcome(self) -> Outcome: ...
    @property
    def pair(self) -> int: ...
    @property
    def distance(self) -> float: ...
    @property
    def uncertainty(self) -> float: ...
    @property
    def time(self) -> float: ...
    @property
    def until(self) -> float: ...
    @property
    def nearest(self) -> ClosestApproach: ...
    @property
    def tightest(self) -> ClosestApproach: ...
    @property
    def floor(self) -> float: ...
    @property
    def segments(self) -> int: ...
    @property
    def looks(self) -> int: ...

class Prover:
    def __init__(
        self,
        scene: Scene,
        positions: _Integers,
        velocities: _Integers,
        state: _Doubles,
        curve: tuple[_Doubles, _Doubles, _Doubles],
        margins: _Doubles,
        slack: float,
    ) -> None: ...
    def prove(self, interrupt: Callable[[], object]) -> Proof: ...
    def prove_in_order(self, interrupt: Callable[[], object], resolution: float) -> Proof: ...
    def bounds(self, halvings: Sequence[int]) -> tuple[float, float, float, _Doubles]: ...

type _GroupMotion = tuple[_Integers, _Integers, _Doubles, _Doubles, _Doubles]

class Encounter:
    @property
    def pair(self) -> int: ...
    @property
    def distance(self) -> float: ...
    @property
    def times(self) -> tuple[float, float]: ...

class BesideProof:
    @property
    def outcome(self) -> Outcome: ...
    @property
    def worst(self) -> Encounter: ...
    @property
    def pairs(self) -> int: ...
    @property
    def segments(self) -> int: ...

class BesideProver:
    def __init__(
        self,
        scene: Scene,
        first: _GroupMotion,
        second: _GroupMotion,
        state: _Doubles,
        margins: _Doubles,
        slack: float,
    ) -> None: ...
    def prove(self, interrupt: Callable[[], object]) -> BesideProof: ...

def batch_kernels() -> list[str]: ...
def peak(coefficients: _Doubles, tolerance: float) -> tuple[float, int, float]: ...
def load_rows(
    instants: tuple[_Integers, _Integers, _Doubles, _Doubles, _Doubles, _Doubles, float],
    ratios: _Doubles,
    derivatives: _Doubles,
    layout: tuple[_Integers, _Integers],
    radii: _Doubles,
    bound: float,
    price: float,
    is_static: bool,
    is_one_sided: bool,
) -> tuple[
    tuple[_Integers, _Integers, _Doubles, _Doubles, _Doubles],
    tuple[_Integers, _Integers, _Doubles, _Doubles, _Doubles],
]: ...
def solve_penalty_qp(
    variables: tuple[_Doubles, _Doubles, _Doubles, _Doubles],
    rows: tuple[_Integers, _Integers, _Doubles],
    products: tuple[_Integers, _Doubles, _Doubles],
    balls: tuple[_Integers, _Integers, _Doubles, _Doubles],
    least: _Doubles,
    price: _Doubles,
    tolerance: float,
    max_steps: int,
) -> tuple[_Doubles, int, float]: ...
def path_cells(
    path: tuple[_Doubles, _Doubles], velocity: _Doubles, acceleration: _Doubles
) -> tuple[
    _Doubles,
    np.ndarray[Any, np.dtype[np.bool_]],
    _Doubles,
    _Doubles,
    _Doubles,
    _Doubles,
    _Doubles,
    float,
]: ...
def profile_between(
    edges: _Doubles,
    x: _Doubles,
    is_line: np.ndarray[Any, np.dtype[np.bool_]],
    speed: _Doubles,
    acceleration: _Doubles,
    braking: _Doubles,
) -> tuple[_Doubles, _Doubles, _Doubles, _Doubles, _Doubles]: ...
def compose(
    path: tuple[_Doubles, _Doubles],
    s: _Doubles,
    v: _Doubles,
    a: _Doubles,
    j: _Doubles,
    h: _Doubles,
) -> tuple[_Doubles, _Integers, _Doubles]: ...
def utilization(polynomials: _Doubles, limits: _Doubles, gap: float) -> tuple[float, int]: ...
def fastest_chain(
    positions: _Doubles,
    peaks: _Doubles,
    speeds: _Doubles,
    jerk_shares: _Doubles,
    most_intervals: int,
) -> tuple[_Integers, _Integers, _Doubles, _Doubles, _Doubles]: ...
def optimize_profile(
    path: tuple[_Doubles, _Doubles],
    profile: tuple[_Doubles, _Doubles, _Doubles, _Doubles, _Doubles],
    phases: tuple[_Doubles, _Doubles],
    limits: _Doubles,
) -> tuple[_Doubles, _Doubles, _Doubles, _Doubles, _Doubles]: ...

class CheckedEdges:
    def __init__(
        self,
        checker: Checker | None,
        num_positions: int,
        resolution: float,
        look: Callable[[], None],
        are_free: Callable[[_Doubles, _Doubles], _Flags],
        first_free: Callable[[_Doubles, _Doubles], int],
    ) -> None: ...
    @property
    def num_edges(self) -> int: ...
    @property
    def num_states(self) -> int: ...

def skip_vertices(
    edges: CheckedEdges, waypoints: _Doubles, is_over: Callable[[], bool]
) -> _Doubles: ...
def tighten(edges: CheckedEdges, waypoints: _Doubles, max_parts: int) -> _Doubles: ...
def first_of_clusters(
    rows: _Doubles, targets: _Integers, is_periodic: _Flags, tolerance: float
) -> _Flags: ...
def relax_path(
    edges: CheckedEdges,
    waypoints: _Doubles,
    max_sweeps: int,
    min_gain: float,
    first_whole_fraction: float,
    max_whole_fraction: float,
    growth: float,
    shrinkage: float,
    is_over: Callable[[], bool],
) -> _Doubles: ...
def backtrack(
    edges: CheckedEdges,
    waypoints: _Doubles,
    free_path: _Doubles,
    first_fraction: float,
    growth: float,
    max_fraction: float,
) -> _Doubles: ...
def cut_corners(
    edges: CheckedEdges, waypoints: _Doubles, fractions: _Doubles, min_gain: float
) -> _Doubles: ...
