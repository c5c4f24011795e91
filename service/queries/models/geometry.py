"""What a scene looks like."""

from typing import Annotated, Any, Self

from pydantic import Field, StringConstraints

from planning.domain.geometry import shapes
from planning.domain.scene import geometry as domain
from planning.world.documents.shape_document import EmptyDocument, RoundDocument
from service.api.models import Pose, RequestModel, ResponseModel

type Digest = Annotated[str, StringConstraints(pattern=r"^[0-9a-f]{64}$")]


class MeshRequest(RequestModel):
    """Ask for a mesh of a scene."""

    sha256: Digest = Field(description="sha256 of its bytes")


class MeshName(ResponseModel):
    """A mesh, in a file of its own."""

    sha256: str = Field(
        description="sha256 of the bytes of `GET /v1/scenes/{scene}/geometry/{sha256}.glb`: "
        "glTF 2.0, "
        "binary; as an exception to glTF its z axis points up"
    )


class VisibleShape(ResponseModel):
    """A shape that is drawn: exactly one of the first seven members is not null."""

    box: list[float] | None = Field(default=None, description="Full side lengths x, y, z [m]")
    sphere: float | None = Field(default=None, description="Radius [m]")
    cylinder: RoundDocument | None = Field(default=None, description="Along z")
    capsule: RoundDocument | None = Field(default=None, description="Capsule along z")
    ellipsoid: list[float] | None = Field(default=None, description="Semi-axes x, y, z [m]")
    half_space: EmptyDocument | None = Field(default=None, description="All points with z <= 0")
    mesh: MeshName | None = Field(default=None, description="Mesh of triangles")
    pose: Pose = Field(description="Pose on its body")
    color: list[float] = Field(
        description="Red, green, blue, opacity, 0 to 1; a mesh with materials has its own colours"
    )

    @classmethod
    def from_domain(cls, shape: domain.VisibleShape) -> Self:
        """Return a shape."""
        pose, color = Pose.from_domain(shape.X_BS), shape.color.tolist()
        return cls(**_parameters(shape.shape), pose=pose, color=color)


def _parameters(shape: Any) -> dict[str, Any]:  # noqa: PLR0911  (one return per shape)
    match shape:
        case shapes.Box():
            return {"box": shape.size.tolist()}
        case shapes.Sphere():
            return {"sphere": shape.radius}
        case shapes.Cylinder():
            return {"cylinder": RoundDocument(radius=shape.radius, length=shape.length)}
        case shapes.Capsule():
            return {"capsule": RoundDocument(radius=shape.radius, length=shape.length)}
        case shapes.Ellipsoid():
            return {"ellipsoid": shape.semi_axes.tolist()}
        case domain.MeshFile():
            return {"mesh": MeshName(sha256=shape.sha256)}
        case _:
            return {"half_space": EmptyDocument()}


class VisibleBody(ResponseModel):
    """A body that is drawn."""

    name: str = Field(description="Full name, which is also that of its frame")
    pose: Pose | None = Field(
        default=None,
        description="Pose in world; null for what moves with a robot: `POST …/fk` tells "
        "where its frame is",
    )
    shapes: list[VisibleShape] = Field(
        description="Its visual shapes; its collision shapes if it has none"
    )


class Geometry(ResponseModel):
    """Shapes of the bodies of a scene, as they look; those of a revision never change."""

    bodies: list[VisibleBody] = Field(description="Bodies, sorted by name")

    @classmethod
    def from_domain(cls, bodies: tuple[domain.VisibleBody, ...]) -> Self:
        """Return what bodies look like."""
        return cls(
            bodies=[
                VisibleBody(
                    name=body.name,
                    pose=None if body.X_WB is None else Pose.from_domain(body.X_WB),
                    shapes=[VisibleShape.from_domain(shape) for shape in body.shapes],
                )
                for body in bodies
            ]
        )
