"""NumPy's .npz: arrays by the names that they have in the JSON."""

import io

import numpy as np

from service.plans.models.trajectory import Trajectory


def to_arrays(motion: Trajectory) -> bytes:
    """Return a file that `numpy.load` reads, without pickles."""
    file = io.BytesIO()
    np.savez(
        file,
        joint_names=np.array(motion.joint_names, dtype=np.str_),
        velocity_names=np.array(motion.velocity_names, dtype=np.str_),
        times=np.array(motion.times),
        positions=np.array(motion.positions),
        velocities=np.array(motion.velocities),
        accelerations=np.array(motion.accelerations),
    )
    return file.getvalue()
