"""SceneView: a scene of the server in one browser's 3-D view: robot, ghost, red pairs, trace."""

import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import viser

from service.studio.drawing.camera import place_camera, seen_boxes
from service.studio.drawing.shapes import TRUE, Paint, draw_shape
from service.studio.drawing.stage import set_stage
from service.studio.numbers import Array

GHOST = Paint(color=(72, 149, 239), opacity=0.35, casts_shadow=False)
BLOCKED = Paint(color=(230, 57, 70), opacity=0.45, casts_shadow=False)
_FAINT = Paint(color=(148, 163, 184), opacity=0.18, casts_shadow=False)
_RED = Paint(color=(230, 57, 70), opacity=0.75, grown=0.0015, casts_shadow=False)
_PALE_RED = Paint(color=(230, 57, 70), opacity=0.25, grown=0.0015, casts_shadow=False)
_AMBER = Paint(color=(255, 183, 3), opacity=0.75, grown=0.0015, casts_shadow=False)
_PALE_AMBER = Paint(color=(255, 183, 3), opacity=0.25, grown=0.0015, casts_shadow=False)
_MARGIN = (255, 183, 3)
_TRACE_THICKNESS = 0.008
_FRAME_LENGTH, _FRAME_RADIUS = 0.07, 0.0025


class SceneView:
    """The bodies of a scene, drawn for one browser."""

    def __init__(
        self,
        client: viser.ClientHandle,
        bodies: Sequence[Mapping[str, Any]],
        mesh: Callable[[str], bytes],
    ) -> None:
        """Draw the bodies; what moves has no place before `show` says where.

        Args:
            client: The browser.
            bodies: The API's geometry.
            mesh: Returns a mesh by its digest.
        """
        self._client = client
        self._bodies = {body["name"]: body for body in bodies}
        self._mesh = mesh
        self._lock = threading.RLock()
        self._layers: dict[str, dict[str, viser.FrameHandle]] = {}
        self._poses: dict[str, Array] = {}
        self._ghost_paint = GHOST
        self._marks: list[viser.SceneNodeHandle] = []
        self._frames: dict[str, viser.FrameHandle] = {}
        self._num_updates = self._num_others = 0
        client.scene.reset()
        set_stage(client.scene)
        with client.atomic():
            self._layers["robot"] = self._draw("robot", self._bodies, TRUE)
            self._poses |= _fixed_poses(self._bodies)
            self._place("robot", self._poses)

    @property
    def moving(self) -> list[str]:
        """Names of the bodies that move with a robot."""
        return [name for name, body in self._bodies.items() if body["pose"] is None]

    def update(self, bodies: Sequence[Mapping[str, Any]]) -> None:
        """Draw other bodies: what is as it was stays.

        Args:
            bodies: The API's geometry.
        """
        with self._lock, self._client.atomic():
            now = {body["name"]: body for body in bodies}
            robot = self._layers["robot"]
            for name, body in self._bodies.items():
                if now.get(name) != body:
                    robot.pop(name).remove()
                    self._poses.pop(name, None)
            changed = {n: body for n, body in now.items() if self._bodies.get(n) != body}
            self._bodies = now
            self._num_updates += 1
            robot |= self._draw(f"edits/{self._num_updates}", changed, TRUE)
            self._poses |= _fixed_poses(changed)
            self._place("robot", self._poses)

    def has(self, body: str) -> bool:
        """Return whether a body is drawn."""
        return body in self._poses

    def pose_of(self, body: str) -> Array:
        """Return where a body is drawn: X_WB, shape (7,)."""
        return self._poses[body]

    def show(self, poses: Mapping[str, Array]) -> None:
        """Put the robots somewhere: X_WB of bodies, shape (7,)."""
        with self._lock:
            self._poses |= poses
            self._place("robot", poses)

    def show_ghost(self, poses: Mapping[str, Array] | None, paint: Paint = GHOST) -> None:
        """Put the ghost of the robots somewhere, or take it away."""
        with self._lock:
            if poses is None or paint is not self._ghost_paint:
                self._remove("ghost")
            if poses is None:
                return
            self._ghost_paint = paint
            if "ghost" not in self._layers:
                moving = {name: self._bodies[name] for name in self.moving if name in poses}
                self._layers["ghost"] = self._draw("ghost", moving, paint)
            self._place("ghost", poses)

    def show_beside(
        self, name: str, poses: Mapping[str, Array] | None, paint: Paint = GHOST
    ) -> None:
        """Put a further ghost somewhere, or take it away; each has a name and a paint."""
        with self._lock:
            layer = f"beside/{name}"
            if poses is None:
                self._remove(layer)
                return
            if layer not in self._layers:
                bodies = {name: self._bodies[name] for name in poses if name in self._bodies}
                self._layers[layer] = self._draw(layer, bodies, paint)
            self._place(layer, poses)

    def show_others(self, all_poses: Sequence[Mapping[str, Array]]) -> None:
        """Show fainter ghosts beside the ghost, as many as there are poses; none to clear."""
        with self._lock, self._client.atomic():
            for i in range(len(all_poses), self._num_others):
                self._remove(f"others/{i}")
            self._num_others = len(all_poses)
            for i, poses in enumerate(all_poses):
                layer = f"others/{i}"
                if layer not in self._layers:
                    moving = {name: self._bodies[name] for name in self.moving if name in poses}
                    self._layers[layer] = self._draw(layer, moving, _FAINT)
                self._place(layer, poses)

    def mark_pairs(self, pairs: Iterable[Mapping[str, Any]], poses: Mapping[str, Array]) -> None:
        """Draw bodies that collide in red, with their depth, and bodies that are near in amber.

        Args:
            pairs: `bodies`, `points` and `depth`, as the API has them; none to clear. Near bodies
                have no depth above 0.
            poses: Of bodies that are elsewhere than the robot: the ghost's.
        """
        with self._lock, self._client.atomic():
            self._remove("marked")
            for mark in self._marks:
                mark.remove()
            self._marks = []
            chosen = list(pairs)
            names = {name for pair in chosen for name in pair["bodies"] if name in self._bodies}
            moving = {name: self._bodies[name] for name in sorted(names & {*self.moving})}
            fixed = {name: self._bodies[name] for name in sorted(names - {*self.moving})}
            collides = any(pair["depth"] > 0 for pair in chosen)
            strong, pale = (_RED, _PALE_RED) if collides else (_AMBER, _PALE_AMBER)
            self._layers["marked"] = {
                **self._draw("marked/moving", moving, strong),
                **self._draw("marked/fixed", fixed, pale),
            }
            self._place("marked", {**self._poses, **poses})
            for i, pair in enumerate(chosen):
                self._mark(i, pair)

    def draw_trace(self, name: str, points: Array, colors: Array) -> viser.SceneNodeHandle:
        """Draw the path of a tool.

        Args:
            name: Of the path.
            points: p_WT [m], shape (n, 3), n >= 2.
            colors: Of the points, 0 to 255, shape (n, 3).
        """
        segments = np.stack([points[:-1], points[1:]], axis=1)
        shades = np.stack([colors[:-1], colors[1:]], axis=1).astype(np.uint8)
        return self._client.scene.add_line_segments(
            f"/trace/{name}", segments, shades, thickness=_TRACE_THICKNESS
        )

    def draw_frames(self, poses: Mapping[str, Array]) -> None:
        """Draw the named frames as small triads: X_WF by name, shape (7,); no others remain."""
        with self._lock, self._client.atomic():
            for name in [name for name in self._frames if name not in poses]:
                self._frames.pop(name).remove()
            for name, pose in poses.items():
                if name not in self._frames:
                    self._frames[name] = self._client.scene.add_frame(
                        f"/frames/{name}", axes_length=_FRAME_LENGTH, axes_radius=_FRAME_RADIUS
                    )
                    self._client.scene.add_label(f"/frames/{name}/name", name)
                self._frames[name].position = tuple(pose[:3])
                self._frames[name].wxyz = tuple(pose[3:])

    def show_frames(self, *, is_visible: bool) -> None:
        """Show the named frames, or hide them."""
        for frame in self._frames.values():
            frame.visible = is_visible

    def show_margin(self, margin: float) -> None:
        """Show what is kept free around the bodies that never move [m]; 0 to hide it."""
        with self._lock, self._client.atomic():
            self._remove("margin")
            if margin > 0:
                fixed = {n: body for n, body in self._bodies.items() if body["pose"] is not None}
                paint = Paint(color=_MARGIN, opacity=0.2, grown=margin, casts_shadow=False)
                self._layers["margin"] = self._draw("margin", fixed, paint)
                self._place("margin", self._poses)

    def aim(self) -> None:
        """Look at the robots and the frames from the front, past what stands around them."""
        robots = [self._poses[name][:3] for name in self.moving if name in self._poses]
        all_of_it = [pose[:3] for pose in self._poses.values()] or [np.zeros(3)]
        frames = [np.array(frame.position) for frame in self._frames.values()]
        boxes = seen_boxes(list(self._bodies.values()))
        camera, target = place_camera(np.array([*(robots or all_of_it), *frames]), boxes)
        with self._client.atomic():
            self._client.camera.up_direction = (0.0, 0.0, 1.0)
            self._client.camera.position = tuple(camera)
            self._client.camera.look_at = tuple(target)

    def _draw(
        self, layer: str, bodies: Mapping[str, Mapping[str, Any]], paint: Paint
    ) -> dict[str, viser.FrameHandle]:
        scene, found = self._client.scene, dict[str, viser.FrameHandle]()
        for i, (name, body) in enumerate(bodies.items()):
            path = f"/{layer}/{i}"
            found[name] = scene.add_frame(path, show_axes=False)
            for k, shape in enumerate(body["shapes"]):
                draw_shape(scene, f"{path}/{k}", shape, self._mesh, paint)
        return found

    def _place(self, layer: str, poses: Mapping[str, Array]) -> None:
        with self._client.atomic():
            for name, node in self._layers.get(layer, {}).items():
                if name in poses:
                    node.position = tuple(poses[name][:3])
                    node.wxyz = tuple(poses[name][3:])

    def _remove(self, layer: str) -> None:
        for node in self._layers.pop(layer, {}).values():
            node.remove()

    def _mark(self, i: int, pair: Mapping[str, Any]) -> None:
        points = np.array(pair["points"])
        depth = 1000 * float(pair["depth"])
        if len(points) == 2 and depth > 0:
            names = " - ".join(name.rpartition("::")[2] for name in pair["bodies"])
            text = f"{names}: {depth:.0f} mm deep"
            self._marks.append(
                self._client.scene.add_label(
                    f"/marks/{i}", text, position=tuple(points.mean(axis=0))
                )
            )


def _fixed_poses(bodies: Mapping[str, Mapping[str, Any]]) -> dict[str, Array]:
    """Return X_WB of the bodies that never move, by name, shape (7,)."""
    return {
        name: np.array([*body["pose"]["position"], *body["pose"]["quaternion"]])
        for name, body in bodies.items()
        if body["pose"] is not None
    }
