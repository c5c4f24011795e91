"""Every refusal over HTTP, and the one table from our errors to a status.

Requests that could not become jobs are answered with a problem document (RFC 9457). A plan that
was tried and failed is no HTTP error: it is a finished job that carries its failure.
"""

from http import HTTPStatus
from typing import Any, ClassVar

from planning import errors as planning_errors
from planning.errors import Evidence, WayproofError
from service.jobs import errors as job_errors


class Refusal(WayproofError):
    """A request that the service does not carry out.

    Attributes:
        status: The HTTP status of the answer.
    """

    status: ClassVar[int] = 400


class UnreadableBody(Refusal):
    """The body is not what its content type says; evidence: `line` or `position`."""

    code = "unreadable_body"
    status = 400


class HostNotAllowed(Refusal):
    """The request is for a server of another name; evidence: `host`."""

    code = "host_not_allowed"
    status = 400


class Unauthorized(Refusal):
    """The request has no key that is valid; evidence: none."""

    code = "unauthorized"
    status = 401


class ScopeMissing(Refusal):
    """The key is not good for that; evidence: the scope that is `needed`, and its `scopes`."""

    code = "scope_missing"
    status = 403


class OriginNotAllowed(Refusal):
    """A web page of another origin asks; evidence: `origin`."""

    code = "origin_not_allowed"
    status = 403


class RequestTimeout(Refusal):
    """The body did not arrive in time; evidence: `allowed` [s]."""

    code = "request_timeout"
    status = 408


class ClientLeft(Refusal):
    """The client closed its connection before it had the answer, which nothing waits for then."""

    code = "client_left"
    status = 499


class UnknownResource(Refusal):
    """There is nothing of that id; evidence: `kind`, `id`."""

    code = "not_found"
    status = 404

    @classmethod
    def of(cls, kind: str, identifier: str) -> "UnknownResource":
        """Build the error for an id that does not exist."""
        shown = identifier if len(identifier) <= 80 else f"{identifier[:80]}..."
        verb = "are" if kind.endswith("s") else "is"
        return cls(f"there {verb} no {kind} {shown!r}", {"kind": kind, "id": shown})


class AddressNotAllowed(Refusal):
    """A webhook leads where the server sends nothing; evidence: `host`, `pointer`."""

    code = "address_not_allowed"
    status = 422


class MethodNotAllowed(Refusal):
    """The resource is there, but does not do that."""

    code = "method_not_allowed"
    status = 405


class NotReady(Refusal):
    """Workers are not warm yet, or cannot be; evidence: `faults` by queue."""

    code = "not_ready"
    status = 503


class WrongCount(Refusal):
    """A list of joint values that does not fit the group; evidence: `expected`, `got`, `names`."""

    code = "wrong_joint_count"
    status = 409


class NotFinished(Refusal):
    """The plan has no trajectory (yet); evidence: `state`, `failure`."""

    code = "no_trajectory"
    status = 409


class NoRegions(Refusal):
    """No regions fit the plan; evidence: `digest`, `group`, `margin`, and what is `there`."""

    code = "no_regions"
    status = 409


class StartMismatch(Refusal):
    """The plan does not start where the robot is; evidence: `start`, `positions`, `distance`."""

    code = "start_mismatch"
    status = 409


class RobotBusy(Refusal):
    """An execution moves one of these robots, or waits for one; evidence: `execution`, `group`."""

    code = "robot_busy"
    status = 409


class RobotStateUnknown(Refusal):
    """It is not known where a robot of this scene is; evidence: `robots`."""

    code = "robot_state_unknown"
    status = 409


class RevisionConflict(Refusal):
    """The scene has moved on since; evidence: `revision`, `latest`."""

    code = "revision_conflict"
    status = 409

    @classmethod
    def of(cls, identifier: str, revision: int, latest: int) -> "RevisionConflict":
        """Build the error for a revision that is not the latest."""
        message = f"scene {identifier} is at revision {latest} by now, not {revision}"
        return cls(message, {"revision": revision, "latest": latest})


class RevisionMismatch(Refusal):
    """The scene is not at the revision of `If-Match`; evidence: `revision`, `etag`, `asked`."""

    code = "revision_mismatch"
    status = 412


class SceneNotKept(Refusal):
    """What a scene was made from is not there any more; evidence: `digest`."""

    code = "scene_not_kept"
    status = 409

    @classmethod
    def of(cls, digest: str) -> "SceneNotKept":
        """Build the error for the scene with a digest."""
        message = (
            f"what is kept of the scene with digest {digest} is not what was accepted, or was "
        )
        message += "written before scenes kept their files; post the scene again"
        return cls(message, {"digest": digest})


class BodyTooLarge(Refusal):
    """The body has more bytes than are read; evidence: `bound`."""

    code = "body_too_large"
    status = 413


class UnsupportedMediaType(Refusal):
    """The body has a content type that is not read here; evidence: `known`."""

    code = "unsupported_media_type"
    status = 415


class RequestInvalid(Refusal):
    """The body or the parameters have faults; evidence: `faults` with path and message."""

    code = "request_invalid"
    status = 422


class RateLimited(Refusal):
    """The caller has made too many requests; evidence: `limit`, `retry_after`."""

    code = "rate_limited"
    status = 429


class DiskFull(Refusal):
    """The data folder has no room for what the request needs; evidence: `reason`, `retry_after`."""

    code = "disk_full"
    status = 503


class BackupImpossible(WayproofError):
    """The records cannot be backed up, or restored, by this program; evidence: `database`."""

    code = "backup_impossible"


class BackupInvalid(WayproofError):
    """A file is no backup, or is damaged; evidence: `file`, and `member` if one is wrong."""

    code = "backup_invalid"


class RecordsExist(WayproofError):
    """A backup is not restored over records; evidence: `database`."""

    code = "records_exist"


class KeyExists(WayproofError):
    """A key of this name is in use; evidence: `name`."""

    code = "key_exists"


class Unguarded(WayproofError):
    """The server would listen beyond this machine, and ask for no keys; evidence: `host`."""

    code = "unguarded"


class ServerStopping(Refusal):
    """The server ends before it could answer; evidence: none."""

    code = "server_stopping"
    status = 503


_STATUS: dict[type[WayproofError], int] = {
    planning_errors.SceneInvalid: 422,
    planning_errors.SceneEditImpossible: 409,
    planning_errors.AssetNotFound: 422,
    planning_errors.ModelInvalid: 422,
    planning_errors.ProblemInvalid: 422,
    planning_errors.UnknownName: 422,
    planning_errors.IllegalTransition: 409,
    planning_errors.InputError: 422,
    planning_errors.PlanningFailure: 409,
    planning_errors.DeadlineExceeded: 503,
    job_errors.IdempotencyConflict: 409,
    job_errors.JobInUse: 409,
    job_errors.QueueFull: 429,
    job_errors.QueueTimeout: 503,
    job_errors.UnknownJob: 404,
    job_errors.WorkerCrashed: 503,
    job_errors.WorkerUnresponsive: 503,
    job_errors.HostLost: 503,
    job_errors.MemoryLimitExceeded: 503,
    job_errors.DatabaseTaken: 503,
    job_errors.DatabaseUnavailable: 503,
    job_errors.InternalError: 500,
    planning_errors.ExecutionFailure: 409,
    WayproofError: 500,
}


def status_of(error: WayproofError) -> int:
    """Return the HTTP status that an error is answered with."""
    if isinstance(error, Refusal):
        return error.status
    return next(_STATUS[base] for base in type(error).__mro__ if base in _STATUS)


def problem_of(code: str, status: int, detail: str, evidence: Evidence) -> dict[str, Any]:
    """Return the problem document of a refusal; `errors` says where something is wrong.

    They are the `errors` of the evidence, or its `faults`, which say more, or its one `pointer`.
    """
    title = code.replace("_", " ").capitalize() if code else HTTPStatus(status).phrase
    problem = {
        "type": f"urn:wayproof:problem:{code}",
        "title": title,
        "status": status,
        "code": code,
        "detail": detail,
        "evidence": {name: fact for name, fact in evidence.items() if name != "errors"},
    }
    faults = [evidence] if "pointer" in evidence else evidence.get("faults", ())
    # Workers have faults as well, by queue.
    listed = faults if isinstance(faults, list) else ()
    errors = evidence.get("errors") or [_error_of({"message": detail, **one}) for one in listed]
    return {**problem, "errors": errors} if errors else problem


def _error_of(fault: Any) -> dict[str, Any]:
    """Return what `errors` says of a fault of the body or of a parameter."""
    pointer, message = fault["pointer"], fault["message"]
    shown = message if pointer else f"{fault['path']}: {message}"
    error = {"pointer": pointer, "message": shown, "nearest": fault.get("nearest", [])}
    return {**error, "parameter": fault["parameter"]} if "parameter" in fault else error
