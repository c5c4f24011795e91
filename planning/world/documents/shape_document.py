"""ShapeDocument: `{box: [x, y, z]}`, `{sphere: r}`, `{cylinder: {...}}` and so on."""

from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, ConfigDict, Field, StringConstraints, model_validator

from planning.domain.geometry.shapes import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Mesh,
    Shape,
    Sphere,
)
from planning.domain.value import frozen
from planning.world.documents.strict_model import Number, Positive, StrictModel

type Sizes = Annotated[list[Positive], Field(min_length=3, max_length=3)]
type Point = Annotated[list[Number], Field(min_length=3, max_length=3)]


def _per_axis(scale: Any) -> Any:
    """Spread one factor over three axes."""
    return [scale] * 3 if isinstance(scale, int | float) else scale


class RoundDocument(StrictModel):
    """Radius and length of a cylinder or capsule [m]; the axis is z."""

    radius: Positive = Field(description="Radius [m]")
    length: Positive = Field(description="Length of the cylindrical part [m]")


class MeshDocument(StrictModel):
    """A mesh file; its convex hull is what counts."""

    uri: Annotated[str, StringConstraints(min_length=1, max_length=1024)] = Field(
        description="Path of an .obj, .vtk or .gltf file"
    )
    scale: Annotated[Sizes, BeforeValidator(_per_axis)] = Field(
        default=[1.0, 1.0, 1.0], description="Factor on the size, or one factor per axis [1]"
    )


class ConvexDocument(StrictModel):
    """The convex hull of points."""

    points: Annotated[list[Point], Field(min_length=4, max_length=10_000)] = Field(
        description="Points [m]; not all in one plane"
    )


class EmptyDocument(StrictModel):
    """No parameters."""


class ShapeDocument(StrictModel):
    """Exactly one of the shapes."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [{"box": [0.4, 0.3, 0.05]}, {"cylinder": {"radius": 0.03, "length": 0.12}}]
        }
    )

    box: Sizes | None = Field(default=None, description="Full side lengths x, y, z [m]")
    sphere: Positive | None = Field(default=None, description="Radius [m]")
    cylinder: RoundDocument | None = None
    capsule: RoundDocument | None = None
    ellipsoid: Sizes | None = Field(default=None, description="Semi-axes x, y, z [m]")
    half_space: EmptyDocument | None = Field(
        default=None, description="All points with z <= 0 in the object's frame"
    )
    mesh: MeshDocument | None = None
    convex: ConvexDocument | None = None

    @model_validator(mode="after")
    def _exactly_one(self) -> "ShapeDocument":
        given = sorted(name for name, shape in self.__dict__.items() if shape is not None)
        if len(given) != 1:
            names = sorted(type(self).model_fields)
            message = f"give exactly one shape of {names}, got {given}"
            raise ValueError(message)
        if self.convex is not None:
            points = np.array(self.convex.points)
            extent = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
            if not extent[-1] > 1e-6:
                message = "the points of `convex` are coplanar: give points that enclose a volume"
                raise ValueError(message)
        return self

    def value(self) -> Shape:  # noqa: PLR0911  (one return per shape)
        """Return the domain's shape."""
        if self.box is not None:
            return Box(frozen(self.box))
        if self.sphere is not None:
            return Sphere(self.sphere)
        if self.cylinder is not None:
            return Cylinder(self.cylinder.radius, self.cylinder.length)
        if self.capsule is not None:
            return Capsule(self.capsule.radius, self.capsule.length)
        if self.ellipsoid is not None:
            return Ellipsoid(frozen(self.ellipsoid))
        if self.convex is not None:
            return Convex(np.array(self.convex.points))
        if self.mesh is not None:
            return Mesh(self.mesh.uri, np.array(self.mesh.scale))
        return HalfSpace()
