from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

type _Doubles = np.ndarray[Any, np.dtype[np.float64]]
type _Integers = np.ndarray[Any, np.dtype[np.int64]]
type _Verdicts = np.ndarray[Any, np.dtype[np.uint8]]

class Scene:
    def __init__(self, num_positions: int, num_velocities: int) -> None: ...
    def add_link(
        self,
        parent: int,
        X_PF: _Doubles,
        kind: int,
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
        kind: int,
        size: _Doubles,
        vertices: _Doubles,
        planes: _Doubles,
        outer: _Doubles,
        inner: _Doubles,
        bound: _Doubles,
    ) -> None: ...
    def add_pair(self, a: int, b: int) -> None: ...

class Checker:
    def __init__(
        self,
        scene: Scene,
        positions: _Integers,
        velocities: _Integers,
        state: _Doubles,
        demands: _Doubles,
        kernel: str = "",
    ) -> None: ...
    def judge(self, qs: _Doubles) -> _Verdicts: ...
    def judge_one(self, q: _Doubles) -> int: ...
    def judge_motions(
        self, origins: _Doubles, displacements: _Doubles, resolution: float
    ) -> tuple[_Verdicts, _Integers]: ...
    def judge_motion(self, origin: _Doubles, displacement: _Doubles, resolution: float) -> int: ...
    def judge_edge(
        self, q0: list[float], q1: list[float], resolution: float
    ) -> tuple[int, int]: ...
    @property
    def doubtful_fixed_pairs(self) -> list[int]: ...
    @property
    def lane_kernel(self) -> str: ...

class IkTolerance:
    def __init__(self, box: _Doubles, freedom: int, axis: int, bound: float) -> None: ...

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

def lane_kernels() -> list[str]: ...

class Sighting:
    @property
    def pair(self) -> int: ...
    @property
    def distance(self) -> float: ...
    @property
    def time(self) -> float: ...

class Proof:
    @property
    def outcome(self) -> int: ...
    @property
    def pair(self) -> int: ...
    @property
    def distance(self) -> float: ...
    @property
    def uncertainty(self) -> float: ...
    @property
    def time(self) -> float: ...
    @property
    def nearest(self) -> Sighting: ...
    @property
    def tightest(self) -> Sighting: ...
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
    def bounds(self, halvings: Sequence[int]) -> tuple[float, float, float, _Doubles]: ...

def peak(coefficients: _Doubles, tolerance: float) -> tuple[float, int, float]: ...
