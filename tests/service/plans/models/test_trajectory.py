"""Trajectories survive JSON exactly."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.sampling import Sampling, sample_trajectory
from planning.domain.robot.joints import Joint, JointType
from service.plans.models.trajectory import Polynomial, Trajectory
from tests.profiles import num_cases


def random_trajectory(seed, kind):
    rng = np.random.default_rng(seed)
    joints = (Joint("r::a", kind), Joint("r::b", JointType.REVOLUTE))
    nq = sum(joint.num_positions for joint in joints)
    nv = sum(joint.num_velocities for joint in joints)
    bases = rng.normal(size=(3, nq))
    bases[:, :4] /= np.linalg.norm(bases[:, :4], axis=1, keepdims=True) if nq > 4 else 1.0
    breaks = np.concatenate([[0.0], np.cumsum(rng.uniform(0.1, 1.0, 3))])
    return TimedTrajectory(joints, breaks, bases, rng.normal(size=(3, 4, nv)))


@given(st.integers(0, 2**32 - 1), st.sampled_from(JointType))
@settings(max_examples=num_cases(6))
def test_polynomials_survive_json_bit_for_bit(seed, kind):
    trajectory = random_trajectory(seed, kind)
    text = Polynomial.from_domain(trajectory).model_dump_json()
    assert Polynomial.model_validate_json(text).to_domain() == trajectory


@given(st.integers(0, 2**32 - 1), st.floats(0.01, 3.0))
@settings(max_examples=num_cases(6))
def test_samples_have_both_ends_and_no_longer_gap_than_asked(seed, period):
    trajectory = random_trajectory(seed, JointType.FLOATING)
    samples = sample_trajectory(trajectory, Sampling(period), np.full(7, np.inf))
    motion = Trajectory.from_samples(samples, (), trajectory)
    assert motion.polynomial.to_domain() == trajectory
    assert Trajectory.model_validate_json(motion.model_dump_json()) == motion
    motion = motion.model_dump()
    times = np.array(motion["times"])
    assert times[0] == 0.0
    assert times[-1] == trajectory.duration == motion["duration"]
    assert np.diff(times).max() <= period * (1 + 1e-9)
    assert np.array(motion["positions"]).shape == (len(times), len(motion["joint_names"]))
    assert np.array(motion["velocities"]).shape == (len(times), len(motion["velocity_names"]))
    assert np.array(motion["accelerations"]).shape == (len(times), len(motion["velocity_names"]))
