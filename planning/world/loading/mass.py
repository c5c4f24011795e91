"""Mass and inertia of objects, from their shapes at uniform density."""

import numpy as np
from pydrake.geometry import Convex, Mesh
from pydrake.multibody.tree import CalcSpatialInertia, RotationalInertia, SpatialInertia

from planning.domain.scene.scene import SceneObject
from planning.world.loading.drake_shapes import drake_shape


def spatial_inertia(thing: SceneObject) -> SpatialInertia:
    """Return the spatial inertia of an object about its origin; zero without a mass.

    It is that of the shape at uniform density, a mesh counting as its convex hull; with a given
    centre of mass, the same rotational inertia about that centre.

    Raises:
        ValueError: The shape has no volume.
    """
    if thing.mass is None:
        return SpatialInertia.Zero()
    shape = drake_shape(thing.shape)
    if isinstance(shape, Mesh):
        hull = shape.GetConvexHull()
        points = np.array([hull.vertex(i) for i in range(hull.num_vertices())])
        shape = Convex(np.asfortranarray(points.T), "hull")
    solid = CalcSpatialInertia(shape, 1.0)
    center = np.array(solid.get_com())
    unit = solid.get_unit_inertia().ShiftToCenterOfMass(center).CopyToFullMatrix3()
    (xx, xy, xz), (_, yy, yz), (*_, zz) = np.array(unit) * thing.mass
    return SpatialInertia.MakeFromCentralInertia(
        thing.mass,
        center if thing.center_of_mass is None else thing.center_of_mass,
        RotationalInertia(xx, yy, zz, xy, xz, yz),
    )
