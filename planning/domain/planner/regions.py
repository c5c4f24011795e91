"""Regions: convex free sets in the configuration space of a group, and their overlaps (portals)."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.value import Value, digest

# Tolerance for a configuration on a face, for rounding [rad or m].
_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class RegionOptions(Value):
    """Options for growing convex regions.

    Attributes:
        num_regions: Largest number of regions.
        coverage: Coverage at which growing stops, as a share of the free configurations in the
            domain, 0 to 1.
        along: First regions: "paths" grows regions along paths from the scene's state to the
            group's named configurations and the scene's frames; "nothing" begins with the cover.
        num_free: Number of consecutive free random configurations after which a region is accepted.
        iterations: Number of times that a region is grown anew around the largest ellipsoid inside
            it.
        bounds: Lowest and highest value [rad or m] by name of a position coordinate, within the
            limits.
        margin: Distance that regions keep [m]; None for the scene's.
        padding: Distance beyond the margin [m]; motions with clearance to spare are quick to prove.
    """

    num_regions: int = 60
    coverage: float = 0.9
    along: Literal["paths", "nothing"] = "paths"
    num_free: int = 5_000
    iterations: int = 3
    bounds: dict[str, tuple[float, float]] = field(default_factory=dict)
    margin: float | None = None
    padding: float = 0.001


@dataclass(frozen=True, eq=False)
class Region(Value):
    """Convex polytope of configurations q with normals q <= offsets, bounded (H-representation).

    Not promised: that all of it is free. `num_free` random configurations in a row were, so with
    95 % confidence less than 3 / num_free of its volume collides (the rule of three).

    Attributes:
        normals: Unit normals of its faces, shape (m, nq).
        offsets: Shape (m,).
        center: A configuration well inside, shape (nq,).
        num_free: Number of consecutive random configurations that were free.
    """

    normals: Float64[np.ndarray, "m nq"]
    offsets: Float64[np.ndarray, " m"]
    center: Float64[np.ndarray, " nq"]
    num_free: int

    def contains(self, qs: Float64[np.ndarray, "n nq"]) -> Bool[np.ndarray, " n"]:
        """Return whether each row lies inside."""
        return (qs @ self.normals.T <= self.offsets + _ROUNDING).all(axis=1)


@dataclass(frozen=True, eq=False)
class Portal(Value):
    """Overlap of two regions.

    Attributes:
        regions: Their rows, the smaller one first.
        point: The center of the largest ball inside both, shape (nq,).
        radius: Its radius.
    """

    regions: tuple[int, int]
    point: Float64[np.ndarray, " nq"]
    radius: float


@dataclass(frozen=True, eq=False)
class Regions(Value):
    """Convex regions of a group in a scene, with their portals and coverage.

    Attributes:
        scene: The scene's digest.
        group: The group's name.
        margin: Distance that every configuration keeps [m], padding not counted.
        seed: Of all randomness.
        lower: Lowest configuration of the domain, shape (nq,).
        upper: Highest configuration of the domain, shape (nq,).
        regions: In the order in which they were grown.
        portals: Overlaps of regions.
        coverage: Share of the domain's free configurations that lie in some region, by sampling.
        coverage_error: Its standard error.
        stopped_by: Why growing ended: "coverage", "num_regions", "deadline" or "exhausted".
    """

    scene: str
    group: str
    margin: float
    seed: int
    lower: Float64[np.ndarray, " nq"]
    upper: Float64[np.ndarray, " nq"]
    regions: tuple[Region, ...]
    portals: tuple[Portal, ...]
    coverage: float
    coverage_error: float
    stopped_by: str

    @cached_property
    def digest(self) -> str:
        """sha256 of the content."""
        return digest(self)

    def containing(self, q: Float64[np.ndarray, " nq"]) -> tuple[int, ...]:
        """Return the rows of the regions that a configuration lies in."""
        return tuple(i for i, region in enumerate(self.regions) if region.contains(q[None])[0])

    @property
    def as_json(self) -> dict[str, Any]:
        """The same as lists and numbers, for JSON; `from_json` restores it bit for bit."""
        return {
            "scene": self.scene,
            "group": self.group,
            "margin": self.margin,
            "seed": self.seed,
            "lower": self.lower.tolist(),
            "upper": self.upper.tolist(),
            "regions": [
                {
                    "normals": region.normals.tolist(),
                    "offsets": region.offsets.tolist(),
                    "center": region.center.tolist(),
                    "num_free": region.num_free,
                }
                for region in self.regions
            ],
            "portals": [
                {
                    "regions": list(portal.regions),
                    "point": portal.point.tolist(),
                    "radius": portal.radius,
                }
                for portal in self.portals
            ],
            "coverage": self.coverage,
            "coverage_error": self.coverage_error,
            "stopped_by": self.stopped_by,
        }

    @classmethod
    def from_json(cls, content: dict[str, Any]) -> "Regions":
        """Build from the result of `as_json`."""
        regions = tuple(
            Region(
                np.array(entry["normals"]),
                np.array(entry["offsets"]),
                np.array(entry["center"]),
                entry["num_free"],
            )
            for entry in content["regions"]
        )
        portals = tuple(
            Portal(
                (entry["regions"][0], entry["regions"][1]),
                np.array(entry["point"]),
                entry["radius"],
            )
            for entry in content["portals"]
        )
        fields: dict[str, Any] = {
            **content,
            "lower": np.array(content["lower"]),
            "upper": np.array(content["upper"]),
            "regions": regions,
            "portals": portals,
        }
        return cls(**fields)
