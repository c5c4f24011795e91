"""The import of the toppra package is deferred until an attribute of it is used."""

import subprocess
import sys

SCRIPT = """
import sys
import planning.retime.toppra.toppra_passes
print([name for name in ("matplotlib", "scipy") if name in sys.modules])
import toppra
path = toppra.SplineInterpolator([0, 1], [[0.0], [1.0]])
limit = toppra.constraint.JointVelocityConstraint([2.0])
motion = toppra.algorithm.TOPPRA([limit], path, parametrizer="ParametrizeConstAccel")
print(motion.compute_trajectory().duration, toppra.algorithm.algorithm.plt.figure.__name__)
print(toppra.interpolator.AbstractGeometricPath.__name__, toppra.solverwrapper.ecosWrapper.__name__)
print(isinstance(path, toppra.interpolator.AbstractGeometricPath))
for module in (toppra, toppra.interpolator, toppra.solverwrapper):
    try:
        module.nothing
    except AttributeError as error:
        print(error)
"""


def test_what_draws_and_makes_splines_is_loaded_once_all_of_toppra_is_wanted() -> None:
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", SCRIPT], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    early, used, classes, is_path, *missing = done.stdout.splitlines()
    assert early == "[]"
    duration, figure = used.split()
    assert 0.5 <= float(duration) < 0.6
    assert figure == "figure"
    assert classes == "AbstractGeometricPath ecosWrapper"
    assert is_path == "True"
    assert len(missing) == 3
    assert all("no attribute 'nothing'" in line for line in missing)
