"""What a request may ask of stops."""

from planning.domain.options import CertifyOptions, RetimeOptions
from planning.errors import ProblemInvalid


def require_bounded_stops(options: RetimeOptions, wanted: CertifyOptions) -> None:
    """Go on only if stops, where they shall be over in time, are held to all that limits a motion.

    A stop brakes as hard as its joints' limits allow. To torques and to accelerations of frames it
    is not held, so a bound on how long it takes would say nothing of the robot.

    Args:
        options: What limits the motion.
        wanted: What to find out about it.

    Raises:
        ProblemInvalid: They are not.
    """
    asked = ["effort"] if options.effort else []
    asked += ["tool_limits" for limit in options.tool_limits if limit.acceleration is not None]
    if wanted.max_stopping_time is not None and asked:
        message = (
            "certify.max_stopping_time: stops are held to the limits of joints, not to torques and "
            f"accelerations of frames; it cannot be asked for together with {asked[0]}"
        )
        evidence = {"field": "certify.max_stopping_time", "limits": list(dict.fromkeys(asked))}
        raise ProblemInvalid(message, evidence)
