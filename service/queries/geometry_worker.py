"""What a scene looks like: shapes, colours and meshes of its bodies."""

from base64 import b64encode

from planning.world.replay.scene_geometry import scene_geometry, scene_mesh
from planning.world.replay.still_writer import Still, still_html
from service.jobs.context import TaskContext
from service.plans.tasks import Page
from service.queries.models.geometry import Geometry, MeshRequest
from service.queries.tasks import GEOMETRY, MESH, VIEW, MeshContent
from service.scenes.tasks import RequestWork, SceneWork
from service.scenes.world_cache import borrow_world


@GEOMETRY.runs
def geometry(work: SceneWork, _: TaskContext) -> Geometry:
    """Return what the bodies of a scene look like.

    Raises:
        InputError: The scene does not load any more.
    """
    with borrow_world(work) as world:
        return Geometry.from_domain(scene_geometry(world))


@MESH.runs
def mesh(work: RequestWork[MeshRequest], _: TaskContext) -> MeshContent:
    """Return a mesh of a scene.

    Raises:
        InputError: The scene does not load any more.
    """
    with borrow_world(work) as world:
        content = scene_mesh(world, work.request.sha256)
    return MeshContent(glb=None if content is None else b64encode(content).decode())


@VIEW.runs
def view(work: SceneWork, _: TaskContext) -> Page:
    """Make the page that shows a scene in 3-D.

    Raises:
        InputError: The scene does not load any more.
    """
    with borrow_world(work) as world:
        return Page(html=still_html(world, Still(world.scene.name)))
