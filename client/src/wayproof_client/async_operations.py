"""Operations, to be awaited. Made by `python -m client.generator`: never edit it."""

from collections.abc import AsyncIterator
from typing import Literal

from wayproof_client.call import Call
from wayproof_client import models, requests
from wayproof_client.async_caller import AsyncCaller


class AsyncOperations(AsyncCaller):
    """A method for each operation of the document.

    All raise `ApiError` for a problem and `httpx.TransportError` if the server is not reached.
    """

    async def get_health(self) -> models.Health:
        """Say that the server is there."""
        return await self.ask(Call("GET", "/healthz"), models.Health)

    async def get_metrics(self) -> str:
        """Count jobs, requests, stages, what waits, workers and failures, as Prometheus reads
        it."""
        return await self.ask_text(Call("GET", "/metrics"))

    async def get_readiness(self) -> models.Readiness:
        """Say whether jobs begin at once: the database answers, and workers have planned a
        motion."""
        return await self.ask(Call("GET", "/readyz"), models.Readiness)

    async def list_batches(
        self,
        *,
        state: models.JobState | None = None,
        scene: str | None = None,
        limit: int | None = None,
        cursor: str | None = None,
    ) -> models.BatchPage:
        """List batches, newest first, without the ids of their plans."""
        return await self.ask(
            Call(
                "GET",
                "/v1/batches",
                query={"state": state, "scene": scene, "limit": limit, "cursor": cursor},
            ),
            models.BatchPage,
        )

    async def all_batches(
        self,
        *,
        state: models.JobState | None = None,
        scene: str | None = None,
        limit: int | None = None,
    ) -> AsyncIterator[models.BatchSummary]:
        """List batches, newest first, without the ids of their plans: all pages."""
        cursor: str | None = None
        while True:
            page = await self.list_batches(state=state, scene=scene, limit=limit, cursor=cursor)
            for item in page.items:
                yield item
            cursor = page.next
            if cursor is None:
                return

    async def delete_batch(self, batch: str) -> None:
        """Delete all plans of a batch, once all have ended."""
        await self.ask_nothing(Call("DELETE", "/v1/batches/{batch}", inserted={"batch": batch}))

    async def get_batch(self, batch: str) -> models.Batch:
        """Show a batch: its plans, and how many of them are in which state."""
        return await self.ask(
            Call("GET", "/v1/batches/{batch}", inserted={"batch": batch}), models.Batch
        )

    async def cancel_batch(self, batch: str) -> models.Batch:
        """End all plans of a batch that have not ended; asking again changes nothing."""
        return await self.ask(
            Call("POST", "/v1/batches/{batch}/cancel", inserted={"batch": batch}), models.Batch
        )

    def stream_batch_events(
        self, batch: str, *, last_event_id: str | None = None
    ) -> AsyncIterator[models.JobEvent]:
        """Stream what happens to all plans of a batch; the data of each event names its `plan`."""
        return self.ask_events(
            Call(
                "GET",
                "/v1/batches/{batch}/events",
                inserted={"batch": batch},
                headers={"Last-Event-ID": last_event_id},
            ),
            models.JobEvent,
        )

    async def list_executions(
        self,
        *,
        state: models.ExecutionState | None = None,
        scene: str | None = None,
        limit: int | None = None,
        cursor: str | None = None,
    ) -> models.ExecutionPage:
        """List executions, newest first; a page in a state before the last may have fewer of
        them."""
        return await self.ask(
            Call(
                "GET",
                "/v1/executions",
                query={"state": state, "scene": scene, "limit": limit, "cursor": cursor},
            ),
            models.ExecutionPage,
        )

    async def all_executions(
        self,
        *,
        state: models.ExecutionState | None = None,
        scene: str | None = None,
        limit: int | None = None,
    ) -> AsyncIterator[models.Execution]:
        """List executions, newest first; a page in a state before the last may have fewer of
        them: all pages."""
        cursor: str | None = None
        while True:
            page = await self.list_executions(state=state, scene=scene, limit=limit, cursor=cursor)
            for item in page.items:
                yield item
            cursor = page.next
            if cursor is None:
                return

    async def create_execution(
        self,
        body: requests.ExecutionRequest,
        *,
        wait: float | None = None,
        prefer: str | None = None,
        idempotency_key: str | None = None,
    ) -> models.Execution:
        """Carry out a motion that starts where its robots are and is proven, beside all that
        moves."""
        return await self.ask(
            Call(
                "POST",
                "/v1/executions",
                query={"wait": wait},
                headers={"prefer": prefer, "Idempotency-Key": idempotency_key},
                body=body,
            ),
            models.Execution,
        )

    async def delete_execution(self, execution: str) -> None:
        """Delete an execution that has ended; the scene keeps its robot where it was left."""
        await self.ask_nothing(
            Call("DELETE", "/v1/executions/{execution}", inserted={"execution": execution})
        )

    async def get_execution(self, execution: str) -> models.Execution:
        """Show an execution: its state, progress, measured positions, tracking error, contacts."""
        return await self.ask(
            Call("GET", "/v1/executions/{execution}", inserted={"execution": execution}),
            models.Execution,
        )

    async def cancel_execution(self, execution: str) -> models.Execution:
        """Bring the robot to rest on its path and end; asking again changes nothing."""
        return await self.ask(
            Call("POST", "/v1/executions/{execution}/cancel", inserted={"execution": execution}),
            models.Execution,
        )

    def stream_execution_events(
        self, execution: str, *, last_event_id: str | None = None
    ) -> AsyncIterator[models.ExecutionEvent]:
        """Stream what happens to an execution: queued, started, stage, status, finished."""
        return self.ask_events(
            Call(
                "GET",
                "/v1/executions/{execution}/events",
                inserted={"execution": execution},
                headers={"Last-Event-ID": last_event_id},
            ),
            models.ExecutionEvent,
        )

    async def pause_execution(self, execution: str) -> models.Execution:
        """Bring the robot to rest on its path, until it is resumed."""
        return await self.ask(
            Call("POST", "/v1/executions/{execution}/pause", inserted={"execution": execution}),
            models.Execution,
        )

    async def resume_execution(self, execution: str) -> models.Execution:
        """Move on after a pause."""
        return await self.ask(
            Call("POST", "/v1/executions/{execution}/resume", inserted={"execution": execution}),
            models.Execution,
        )

    async def set_execution_speed(
        self, execution: str, body: requests.SpeedRequest
    ) -> models.Execution:
        """Change how fast and which way the motion is carried out; the robot stays on its path."""
        return await self.ask(
            Call(
                "POST",
                "/v1/executions/{execution}/speed",
                inserted={"execution": execution},
                body=body,
            ),
            models.Execution,
        )

    async def list_models(self) -> models.ModelList:
        """List the robots that scenes may name."""
        return await self.ask(Call("GET", "/v1/models"), models.ModelList)

    async def get_model(self, name: str) -> models.Model:
        """Show a robot: its groups, joints, limits, tool frames and configurations."""
        return await self.ask(
            Call("GET", "/v1/models/{name}", inserted={"name": name}), models.Model
        )

    async def list_planners(self) -> models.PlannerList:
        """List the planners that a plan may name, with their parameters."""
        return await self.ask(Call("GET", "/v1/planners"), models.PlannerList)

    async def list_plans(
        self,
        *,
        state: models.JobState | None = None,
        scene: str | None = None,
        batch: str | None = None,
        limit: int | None = None,
        cursor: str | None = None,
    ) -> models.PlanPage:
        """List plans, newest first, without their results."""
        return await self.ask(
            Call(
                "GET",
                "/v1/plans",
                query={
                    "state": state,
                    "scene": scene,
                    "batch": batch,
                    "limit": limit,
                    "cursor": cursor,
                },
            ),
            models.PlanPage,
        )

    async def all_plans(
        self,
        *,
        state: models.JobState | None = None,
        scene: str | None = None,
        batch: str | None = None,
        limit: int | None = None,
    ) -> AsyncIterator[models.PlanSummary]:
        """List plans, newest first, without their results: all pages."""
        cursor: str | None = None
        while True:
            page = await self.list_plans(
                state=state, scene=scene, batch=batch, limit=limit, cursor=cursor
            )
            for item in page.items:
                yield item
            cursor = page.next
            if cursor is None:
                return

    async def create_plan(
        self,
        body: requests.PlanRequest,
        *,
        wait: float | None = None,
        include: str | None = None,
        prefer: str | None = None,
        idempotency_key: str | None = None,
    ) -> models.Plan:
        """Request a plan: a job that is polled, streamed or waited for."""
        return await self.ask(
            Call(
                "POST",
                "/v1/plans",
                query={"wait": wait, "include": include},
                headers={"prefer": prefer, "Idempotency-Key": idempotency_key},
                body=body,
            ),
            models.Plan,
        )

    async def create_batch(
        self,
        body: requests.BatchRequest,
        *,
        wait: float | None = None,
        prefer: str | None = None,
        idempotency_key: str | None = None,
    ) -> models.Batch:
        """Request plans for up to 256 problems: all of them are queued, or none."""
        return await self.ask(
            Call(
                "POST",
                "/v1/plans/batch",
                query={"wait": wait},
                headers={"prefer": prefer, "Idempotency-Key": idempotency_key},
                body=body,
            ),
            models.Batch,
        )

    async def delete_plan(self, plan: str) -> None:
        """Delete a plan that has ended; its address is unknown then, and its idempotency key
        free."""
        await self.ask_nothing(Call("DELETE", "/v1/plans/{plan}", inserted={"plan": plan}))

    async def get_plan(self, plan: str, *, include: str | None = None) -> models.Plan:
        """Show a plan: how far it is, and its result once it succeeded."""
        return await self.ask(
            Call("GET", "/v1/plans/{plan}", inserted={"plan": plan}, query={"include": include}),
            models.Plan,
        )

    async def get_plan_bundle(self, plan: str) -> bytes:
        """Pack a plan that succeeded or failed: request, scene, models' files, result,
        versions, test."""
        return await self.ask_bytes(
            Call("GET", "/v1/plans/{plan}/bundle.zip", inserted={"plan": plan})
        )

    async def cancel_plan(self, plan: str) -> models.Plan:
        """End a plan, in whatever state it is; asking again changes nothing."""
        return await self.ask(
            Call("POST", "/v1/plans/{plan}/cancel", inserted={"plan": plan}), models.Plan
        )

    def stream_plan_events(
        self, plan: str, *, last_event_id: str | None = None
    ) -> AsyncIterator[models.JobEvent]:
        """Stream what happens to a plan: queued, started, stage, progress, best-so-far,
        finished."""
        return self.ask_events(
            Call(
                "GET",
                "/v1/plans/{plan}/events",
                inserted={"plan": plan},
                headers={"Last-Event-ID": last_event_id},
            ),
            models.JobEvent,
        )

    async def get_failure_view(self, plan: str) -> str:
        """Show in 3-D where a plan failed: the configuration, the bodies that meet in red, and
        why."""
        return await self.ask_text(
            Call("GET", "/v1/plans/{plan}/failure.html", inserted={"plan": plan})
        )

    async def get_planner_graph(self, plan: str) -> models.PlannerGraph:
        """Show what the planner explored, if `search.keep_graph` of the request had it kept."""
        return await self.ask(
            Call("GET", "/v1/plans/{plan}/graph", inserted={"plan": plan}), models.PlannerGraph
        )

    async def get_plot(
        self,
        plan: str,
        name: Literal[
            "acceleration",
            "clearance",
            "jerk",
            "position",
            "tool_speed",
            "torque",
            "utilisation",
            "velocity",
        ],
    ) -> str:
        """Draw the motion of a plan against its limits, or its clearance, over time."""
        return await self.ask_text(
            Call("GET", "/v1/plans/{plan}/plots/{name}.svg", inserted={"name": name, "plan": plan})
        )

    async def get_replay(self, plan: str) -> str:
        """Replay the motion in 3-D: a self-contained page of Drake's Meshcat."""
        return await self.ask_text(
            Call("GET", "/v1/plans/{plan}/replay.html", inserted={"plan": plan})
        )

    async def get_plan_report(self, plan: str) -> str:
        """Report on a plan that has ended: request, certificate, pictures, charts; for
        printing."""
        return await self.ask_text(
            Call("GET", "/v1/plans/{plan}/report.html", inserted={"plan": plan})
        )

    async def reverse_plan(
        self,
        plan: str,
        *,
        wait: float | None = None,
        include: str | None = None,
        prefer: str | None = None,
        idempotency_key: str | None = None,
    ) -> models.Plan:
        """Request the same motion from its end to its start: a plan of its own, proven anew."""
        return await self.ask(
            Call(
                "POST",
                "/v1/plans/{plan}/reverse",
                inserted={"plan": plan},
                query={"wait": wait, "include": include},
                headers={"prefer": prefer, "Idempotency-Key": idempotency_key},
            ),
            models.Plan,
        )

    async def get_series(
        self, plan: str, *, points: int | None = None, distances: bool | None = None
    ) -> models.Series:
        """Return the numbers of the plots: rates, efforts, limits and their use over time."""
        return await self.ask(
            Call(
                "GET",
                "/v1/plans/{plan}/series",
                inserted={"plan": plan},
                query={"points": points, "distances": distances},
            ),
            models.Series,
        )

    async def get_trajectory(
        self,
        plan: str,
        *,
        period: float | None = None,
        points: int | None = None,
        even: bool | None = None,
        scale: float | None = None,
        polynomial: bool | None = None,
    ) -> models.Trajectory:
        """Sample the motion of a plan anew, slower if `scale` says so, and prove the samples."""
        return await self.ask(
            Call(
                "GET",
                "/v1/plans/{plan}/trajectory",
                inserted={"plan": plan},
                query={
                    "period": period,
                    "points": points,
                    "even": even,
                    "scale": scale,
                    "polynomial": polynomial,
                },
            ),
            models.Trajectory,
        )

    async def get_trajectory_as(
        self,
        plan: str,
        *,
        format: Literal["json", "csv", "ros2", "npz", "urscript", "mcap", "rerun"],
        period: float | None = None,
        points: int | None = None,
        even: bool | None = None,
        scale: float | None = None,
        polynomial: bool | None = None,
    ) -> bytes:
        """Sample the motion of a plan anew, slower if `scale` says so, and prove the samples."""
        return await self.ask_bytes(
            Call(
                "GET",
                "/v1/plans/{plan}/trajectory",
                inserted={"plan": plan},
                query={
                    "format": format,
                    "period": period,
                    "points": points,
                    "even": even,
                    "scale": scale,
                    "polynomial": polynomial,
                },
            )
        )

    async def delete_regions(self, regions: str) -> None:
        """Delete regions that have ended; plans that were made in them stay."""
        await self.ask_nothing(
            Call("DELETE", "/v1/regions/{regions}", inserted={"regions": regions})
        )

    async def get_regions(self, regions: str) -> models.RegionsJob:
        """Show regions: how far they are, and all of them once they have grown."""
        return await self.ask(
            Call("GET", "/v1/regions/{regions}", inserted={"regions": regions}), models.RegionsJob
        )

    async def cancel_regions(self, regions: str) -> models.RegionsJob:
        """End the growth, in whatever state it is; asking again changes nothing."""
        return await self.ask(
            Call("POST", "/v1/regions/{regions}/cancel", inserted={"regions": regions}),
            models.RegionsJob,
        )

    def stream_regions_events(
        self, regions: str, *, last_event_id: str | None = None
    ) -> AsyncIterator[models.JobEvent]:
        """Stream what happens to regions: queued, started, stage, progress, finished."""
        return self.ask_events(
            Call(
                "GET",
                "/v1/regions/{regions}/events",
                inserted={"regions": regions},
                headers={"Last-Event-ID": last_event_id},
            ),
            models.JobEvent,
        )

    async def list_scenes(
        self, *, limit: int | None = None, cursor: str | None = None, name: str | None = None
    ) -> models.ScenePage:
        """List scenes, newest first."""
        return await self.ask(
            Call("GET", "/v1/scenes", query={"limit": limit, "cursor": cursor, "name": name}),
            models.ScenePage,
        )

    async def all_scenes(
        self, *, limit: int | None = None, name: str | None = None
    ) -> AsyncIterator[models.SceneBrief]:
        """List scenes, newest first: all pages."""
        cursor: str | None = None
        while True:
            page = await self.list_scenes(limit=limit, name=name, cursor=cursor)
            for item in page.items:
                yield item
            cursor = page.next
            if cursor is None:
                return

    async def create_scene(
        self,
        body: requests.SceneDocument | str | bytes,
        *,
        media_type: Literal["application/json", "application/yaml"] = "application/yaml",
        idempotency_key: str | None = None,
    ) -> models.Scene:
        """Post a scene as JSON or YAML; it is loaded at once, and its faults are named by line."""
        return await self.ask(
            Call(
                "POST",
                "/v1/scenes",
                headers={"Idempotency-Key": idempotency_key},
                body=body,
                media_type=media_type,
            ),
            models.Scene,
        )

    async def delete_scene(self, scene: str, *, if_match: str | None = None) -> None:
        """Forget a scene; plans that were made in it stay."""
        await self.ask_nothing(
            Call(
                "DELETE",
                "/v1/scenes/{scene}",
                inserted={"scene": scene},
                headers={"If-Match": if_match},
            )
        )

    async def get_scene(
        self, scene: str, *, revision: int | None = None, if_none_match: str | None = None
    ) -> models.Scene:
        """Show a scene, by default its latest revision: document, groups, frames and bodies."""
        return await self.ask(
            Call(
                "GET",
                "/v1/scenes/{scene}",
                inserted={"scene": scene},
                query={"revision": revision},
                headers={"If-None-Match": if_none_match},
            ),
            models.Scene,
        )

    async def edit_scene(
        self, scene: str, body: requests.SceneEdit, *, if_match: str | None = None
    ) -> models.EditedScene:
        """Edit a scene: its next revision, which plans use from now on; older ones stay."""
        return await self.ask(
            Call(
                "PATCH",
                "/v1/scenes/{scene}",
                inserted={"scene": scene},
                headers={"If-Match": if_match},
                body=body,
            ),
            models.EditedScene,
        )

    async def check_configurations(
        self, scene: str, body: requests.CheckRequest, *, revision: int | None = None
    ) -> models.CheckResponse:
        """Check configurations: limits, and every pair of bodies that collides, with its depth."""
        return await self.ask(
            Call(
                "POST",
                "/v1/scenes/{scene}/check",
                inserted={"scene": scene},
                query={"revision": revision},
                body=body,
            ),
            models.CheckResponse,
        )

    async def compute_forward_kinematics(
        self, scene: str, body: requests.FkRequest, *, revision: int | None = None
    ) -> models.FkResponse:
        """Compute where frames are in given configurations."""
        return await self.ask(
            Call(
                "POST",
                "/v1/scenes/{scene}/fk",
                inserted={"scene": scene},
                query={"revision": revision},
                body=body,
            ),
            models.FkResponse,
        )

    async def get_scene_geometry(
        self, scene: str, *, revision: int | None = None, if_none_match: str | None = None
    ) -> models.Geometry:
        """Show what the bodies of a scene look like: shapes, colours, and poses of what is
        fixed."""
        return await self.ask(
            Call(
                "GET",
                "/v1/scenes/{scene}/geometry",
                inserted={"scene": scene},
                query={"revision": revision},
                headers={"If-None-Match": if_none_match},
            ),
            models.Geometry,
        )

    async def get_scene_mesh(
        self, scene: str, sha256: str, *, revision: int | None = None
    ) -> bytes:
        """Return a mesh that the geometry of a scene names."""
        return await self.ask_bytes(
            Call(
                "GET",
                "/v1/scenes/{scene}/geometry/{sha256}.glb",
                inserted={"scene": scene, "sha256": sha256},
                query={"revision": revision},
            )
        )

    async def solve_inverse_kinematics(
        self, scene: str, body: requests.IkRequest, *, revision: int | None = None
    ) -> models.IkResponse:
        """Find all distinct configurations that reach a goal, or say why there is none."""
        return await self.ask(
            Call(
                "POST",
                "/v1/scenes/{scene}/ik",
                inserted={"scene": scene},
                query={"revision": revision},
                body=body,
            ),
            models.IkResponse,
        )

    async def trace_line(
        self, scene: str, body: requests.LineRequest, *, revision: int | None = None
    ) -> models.LineResponse:
        """Move a tool in a straight line as far as it goes, and say exactly why it stops."""
        return await self.ask(
            Call(
                "POST",
                "/v1/scenes/{scene}/line",
                inserted={"scene": scene},
                query={"revision": revision},
                body=body,
            ),
            models.LineResponse,
        )

    async def list_regions(
        self,
        scene: str,
        *,
        state: models.JobState | None = None,
        limit: int | None = None,
        cursor: str | None = None,
    ) -> models.RegionsPage:
        """List the regions that were asked for in a scene, newest first, without their faces."""
        return await self.ask(
            Call(
                "GET",
                "/v1/scenes/{scene}/regions",
                inserted={"scene": scene},
                query={"state": state, "limit": limit, "cursor": cursor},
            ),
            models.RegionsPage,
        )

    async def all_regions(
        self, scene: str, *, state: models.JobState | None = None, limit: int | None = None
    ) -> AsyncIterator[models.RegionsBrief]:
        """List the regions that were asked for in a scene, newest first, without their faces:
        all pages."""
        cursor: str | None = None
        while True:
            page = await self.list_regions(scene, state=state, limit=limit, cursor=cursor)
            for item in page.items:
                yield item
            cursor = page.next
            if cursor is None:
                return

    async def grow_regions(
        self,
        scene: str,
        body: requests.RegionsRequest,
        *,
        wait: float | None = None,
        prefer: str | None = None,
        idempotency_key: str | None = None,
    ) -> models.RegionsJob:
        """Grow convex regions of free configurations, for plans with the planner GCS."""
        return await self.ask(
            Call(
                "POST",
                "/v1/scenes/{scene}/regions",
                inserted={"scene": scene},
                query={"wait": wait},
                headers={"prefer": prefer, "Idempotency-Key": idempotency_key},
                body=body,
            ),
            models.RegionsJob,
        )

    async def get_scene_replay(self, scene: str, *, last: int | None = None) -> str:
        """Replay in 3-D what executions moved in a scene, one motion after the other."""
        return await self.ask_text(
            Call(
                "GET",
                "/v1/scenes/{scene}/replay.html",
                inserted={"scene": scene},
                query={"last": last},
            )
        )

    async def get_scene_state(self, scene: str) -> models.LiveState:
        """Show where the robots of a scene are now, what says so, and what they hold."""
        return await self.ask(
            Call("GET", "/v1/scenes/{scene}/state", inserted={"scene": scene}), models.LiveState
        )

    def stream_scene_state(
        self,
        scene: str,
        *,
        rate: float | None = None,
        most: int | None = None,
        last_event_id: str | None = None,
    ) -> AsyncIterator[models.StateEvent]:
        """Stream the live state: now, unless it was seen, and whenever it changes."""
        return self.ask_events(
            Call(
                "GET",
                "/v1/scenes/{scene}/state/events",
                inserted={"scene": scene},
                query={"rate": rate, "most": most},
                headers={"Last-Event-ID": last_event_id},
            ),
            models.StateEvent,
        )

    async def get_scene_view(self, scene: str, *, revision: int | None = None) -> str:
        """Show a scene in 3-D, the robots where they are: a self-contained page."""
        return await self.ask_text(
            Call(
                "GET",
                "/v1/scenes/{scene}/view.html",
                inserted={"scene": scene},
                query={"revision": revision},
            )
        )

    async def certify_trajectory(
        self, body: requests.CertifyMotionRequest
    ) -> models.CertifyMotionResponse:
        """Hold a trajectory of your own against limits and obstacles, between its samples too."""
        return await self.ask(
            Call("POST", "/v1/trajectories/certify", body=body), models.CertifyMotionResponse
        )

    async def retime_path(self, body: requests.RetimeRequest) -> models.RetimeResponse:
        """Time a path of your own as quickly as the limits allow, and prove the motion."""
        return await self.ask(
            Call("POST", "/v1/trajectories/retime", body=body), models.RetimeResponse
        )

    async def schedule_motions(
        self, body: requests.ScheduleMotionsRequest
    ) -> models.ScheduleMotionsResponse:
        """Begin the motions of several plans as early as they can, and prove all of them
        together."""
        return await self.ask(
            Call("POST", "/v1/trajectories/schedule", body=body), models.ScheduleMotionsResponse
        )

    async def splice_motion(
        self, body: requests.SpliceMotionRequest
    ) -> models.SpliceMotionResponse:
        """Go over from a running motion to another one without a rest in between, and prove it."""
        return await self.ask(
            Call("POST", "/v1/trajectories/splice", body=body), models.SpliceMotionResponse
        )

    async def stop_motion(self, body: requests.StopMotionRequest) -> models.StopMotionResponse:
        """Stop a running motion from an instant of it, as quickly as the limits allow, and
        prove it."""
        return await self.ask(
            Call("POST", "/v1/trajectories/stop", body=body), models.StopMotionResponse
        )

    async def list_webhooks(
        self, *, limit: int | None = None, cursor: str | None = None
    ) -> models.WebhookPage:
        """List webhooks, newest first, without their secrets."""
        return await self.ask(
            Call("GET", "/v1/webhooks", query={"limit": limit, "cursor": cursor}),
            models.WebhookPage,
        )

    async def all_webhooks(self, *, limit: int | None = None) -> AsyncIterator[models.Webhook]:
        """List webhooks, newest first, without their secrets: all pages."""
        cursor: str | None = None
        while True:
            page = await self.list_webhooks(limit=limit, cursor=cursor)
            for item in page.items:
                yield item
            cursor = page.next
            if cursor is None:
                return

    async def create_webhook(
        self, body: requests.WebhookRequest, *, idempotency_key: str | None = None
    ) -> models.NewWebhook:
        """Register an address; it is told what happens from now on, signed with the `secret`."""
        return await self.ask(
            Call("POST", "/v1/webhooks", headers={"Idempotency-Key": idempotency_key}, body=body),
            models.NewWebhook,
        )

    async def delete_webhook(self, webhook: str) -> None:
        """Forget a webhook: it is told nothing more."""
        await self.ask_nothing(
            Call("DELETE", "/v1/webhooks/{webhook}", inserted={"webhook": webhook})
        )

    async def get_webhook(self, webhook: str) -> models.Webhook:
        """Show a webhook: whether it takes what it is told."""
        return await self.ask(
            Call("GET", "/v1/webhooks/{webhook}", inserted={"webhook": webhook}), models.Webhook
        )

    async def enable_webhook(self, webhook: str) -> models.Webhook:
        """Send to a webhook again that was disabled; what happened meanwhile it is not told."""
        return await self.ask(
            Call("POST", "/v1/webhooks/{webhook}/enable", inserted={"webhook": webhook}),
            models.Webhook,
        )
