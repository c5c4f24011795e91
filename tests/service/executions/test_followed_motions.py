"""What is told of a motion that an execution goes on with is all that others need of it."""

import json

import numpy as np
from numpy.polynomial import Polynomial as Power

from planning.domain.curves.curve import TimedTrajectory
from planning.execute.execution import Execution
from planning.execute.runner import Runner
from service.executions.models import MotionData
from service.executions.motions.followed_motions import FollowedMotions
from service.executions.tasks import Commands, NextMotion
from service.jobs.worker.context import PipeContext
from service.jobs.worker.run_task import MAX_EVENT
from service.plans.models.trajectory import Polynomial
from tests.execute.conftest import JOINTS, EchoDriver, limits, quintic


class Pipe:
    """Keeps what is sent."""

    def __init__(self):
        self.sent = []

    def send(self, message):
        self.sent.append(message)


def in_pieces(motion: TimedTrajectory, count: int) -> TimedTrajectory:
    """The same motion as `count` polynomials, one after the other."""
    breaks = np.linspace(0.0, motion.duration, count + 1)
    whole = [Power(column) for column in motion.coefficients[0].T]
    shifted = [[p(Power([begin, 1.0])).coef for p in whole] for begin in breaks[:-1]]
    coefficients = np.zeros((count, 6, len(whole)))
    for row, columns in enumerate(shifted):
        for column, values in enumerate(columns):
            coefficients[row, : len(values), column] = values
    start = motion.positions(breaks[:-1])
    coefficients[:, 0] = 0.0
    return TimedTrajectory(JOINTS, breaks, start, coefficients)


def test_a_long_motion_is_told_whole():
    pipe = Pipe()
    runner = Runner(Execution(quintic(), limits()), EchoDriver())
    motions = FollowedMotions(runner, PipeContext(pipe, 1))
    trajectory = Polynomial.from_domain(in_pieces(quintic(), 600))
    asked = NextMotion(number=1, revision=2, plan="p", trajectory=trajectory, is_spliced=False)
    motions.heed(Commands(next=asked))
    ((event_type, text),) = [message.parts for message in pipe.sent]
    assert event_type == "motion"
    assert len(text) > MAX_EVENT
    told = MotionData.model_validate({**json.loads(text), "at": "2026-01-01T00:00:00Z"})
    assert told.trajectory == trajectory
    assert [each.number for each in told.motions] == [1]
