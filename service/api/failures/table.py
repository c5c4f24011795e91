"""The one table of what the evidence of each error has, and where clients meet it.

An error is told as the `failure` of a job or of an answer, as a problem document, or as both.
"""

from typing import Any

from planning import errors as planning_errors
from planning.errors import InputError, StageFailure, WayproofError
from service import errors as service_errors
from service.api.failures import goals, grasps, inputs, jobs, motions, refusals
from service.api.failures.parts import NoEvidence
from service.jobs import errors as job_errors

# What starlette answers by itself, with a status that has no error of ours.
HTTP_ERROR = "http_error"

_INPUTS: dict[type[WayproofError], Any] = {
    planning_errors.SceneInvalid: inputs.SceneFaultEvidence,
    planning_errors.SceneEditImpossible: inputs.SceneEditEvidence,
    planning_errors.AssetNotFound: inputs.AssetEvidence,
    planning_errors.ModelInvalid: inputs.ModelEvidence,
    planning_errors.ProblemInvalid: inputs.ProblemFieldEvidence,
    planning_errors.UnknownName: inputs.NameEvidence,
}
_STAGES: dict[type[WayproofError], Any] = {
    planning_errors.StartInCollision: goals.PairsEvidence,
    planning_errors.StartTooNear: goals.PairsEvidence,
    planning_errors.StartOutOfLimits: goals.StartLimitsEvidence,
    planning_errors.StartViolatesConstraint: goals.StartConstraintEvidence,
    planning_errors.GoalOutOfLimits: goals.GoalLimitsEvidence,
    planning_errors.GoalInCollision: goals.GoalEvidence,
    planning_errors.GoalTooNear: goals.GoalEvidence,
    planning_errors.GoalUnreachable: goals.GoalEvidence,
    planning_errors.GoalViolatesConstraint: goals.GoalConstraintEvidence,
    planning_errors.ApproachBlocked: goals.GoalEvidence,
    planning_errors.LineBlocked: goals.LineEvidence,
    planning_errors.NoPathFound: motions.SearchEvidence,
    planning_errors.DeadlineExceeded: motions.DeadlineEvidence,
    planning_errors.Canceled: motions.CancelEvidence,
    planning_errors.RetimingFailed: motions.RetimingEvidence,
    planning_errors.ScheduleNotFound: motions.ScheduleEvidence,
    planning_errors.GraspMissed: grasps.GraspEvidence,
    planning_errors.NotCertified: motions.CertificateEvidence,
    planning_errors.IllegalTransition: motions.TransitionEvidence,
    planning_errors.TrackingLost: motions.TrackingEvidence,
    planning_errors.Contact: motions.ContactEvidence,
    planning_errors.TorqueLimitReached: motions.TorqueEvidence,
    planning_errors.GraspLost: grasps.GraspLostEvidence,
    planning_errors.PathBlocked: motions.PathBlockedEvidence,
    planning_errors.DriverLost: motions.DriverLostEvidence,
}
_JOBS: dict[type[WayproofError], Any] = {
    job_errors.WorkerCrashed: jobs.WorkerCrashedEvidence,
    job_errors.WorkerUnresponsive: jobs.WorkerSilentEvidence,
    job_errors.HostLost: jobs.HostLostEvidence,
    job_errors.MemoryLimitExceeded: jobs.MemoryEvidence,
    job_errors.ServerRestarted: jobs.RestartEvidence,
    job_errors.InternalError: jobs.InternalErrorEvidence,
    job_errors.QueueFull: jobs.QueueFullEvidence,
    job_errors.QueueTimeout: jobs.QueueTimeoutEvidence,
    job_errors.IdempotencyConflict: jobs.IdempotencyEvidence,
    job_errors.JobInUse: jobs.InUseEvidence,
    job_errors.UnknownJob: jobs.JobIdEvidence,
    job_errors.DatabaseInUse: jobs.DatabaseEvidence,
    job_errors.DatabaseTooNew: jobs.DatabaseRevisionEvidence,
    job_errors.DatabaseUnrecognized: jobs.ForeignTableEvidence,
    job_errors.DatabaseTaken: jobs.DatabaseTakenEvidence,
    job_errors.DatabaseUnavailable: jobs.StorageEvidence,
}
_REFUSALS: dict[type[WayproofError], Any] = {
    service_errors.UnreadableBody: refusals.UnreadableEvidence,
    service_errors.Unauthorized: NoEvidence,
    service_errors.ScopeMissing: refusals.ScopeEvidence,
    service_errors.HostNotAllowed: refusals.HostEvidence,
    service_errors.OriginNotAllowed: refusals.OriginEvidence,
    service_errors.RequestTimeout: refusals.TimeoutEvidence,
    service_errors.ClientLeft: NoEvidence,
    service_errors.UnknownResource: refusals.UnknownResourceEvidence,
    service_errors.AddressNotAllowed: refusals.AddressEvidence,
    service_errors.MethodNotAllowed: NoEvidence,
    service_errors.NotReady: refusals.ReadinessEvidence,
    service_errors.WrongCount: inputs.CountEvidence,
    service_errors.NotFinished: refusals.NoTrajectoryEvidence,
    service_errors.NoRegions: refusals.NoRegionsEvidence,
    service_errors.StartMismatch: refusals.StartMismatchEvidence,
    service_errors.RobotBusy: refusals.BusyEvidence,
    service_errors.RobotStateUnknown: refusals.RobotStateEvidence,
    service_errors.RevisionConflict: refusals.RevisionEvidence,
    service_errors.RevisionMismatch: refusals.EntityTagEvidence,
    service_errors.SceneNotKept: refusals.DigestEvidence,
    service_errors.BodyTooLarge: refusals.SizeEvidence,
    service_errors.UnsupportedMediaType: refusals.MediaTypeEvidence,
    service_errors.RequestInvalid: inputs.FaultsEvidence,
    service_errors.RateLimited: refusals.RateEvidence,
    service_errors.DiskFull: jobs.StorageEvidence,
    service_errors.ServerStopping: NoEvidence,
    service_errors.BackupImpossible: jobs.DatabaseEvidence,
    service_errors.BackupInvalid: jobs.BackupEvidence,
    service_errors.RecordsExist: jobs.DatabaseEvidence,
    service_errors.KeyExists: refusals.KeyNameEvidence,
    service_errors.Unguarded: refusals.ListenEvidence,
}

# A `TypedDict` of the evidence by error.
EVIDENCE = {**_INPUTS, **_STAGES, **_JOBS, **_REFUSALS}
# Errors that no answer to a request is.
_NEVER_PROBLEMS = {
    planning_errors.TrackingLost,
    planning_errors.Contact,
    planning_errors.TorqueLimitReached,
    planning_errors.GraspLost,
    planning_errors.PathBlocked,
    planning_errors.DriverLost,
    job_errors.ServerRestarted,
    job_errors.DatabaseInUse,
    job_errors.DatabaseTooNew,
    job_errors.DatabaseUnrecognized,
    service_errors.ClientLeft,
    service_errors.BackupImpossible,
    service_errors.BackupInvalid,
    service_errors.RecordsExist,
    service_errors.KeyExists,
    service_errors.Unguarded,
}


# Refusals with which executions end that have waited for their robots.
_LATE_REFUSALS = {
    service_errors.UnknownResource,
    service_errors.StartMismatch,
    service_errors.RobotStateUnknown,
}


def failure_errors() -> list[type[WayproofError]]:
    """Return the errors that a job or an answer can have as its failure."""
    return [
        error
        for error in EVIDENCE
        if issubclass(error, StageFailure | InputError) or error in _LATE_REFUSALS
    ]


def problem_errors() -> list[type[WayproofError]]:
    """Return the errors that problem documents tell of."""
    return [error for error in EVIDENCE if error not in _NEVER_PROBLEMS]
