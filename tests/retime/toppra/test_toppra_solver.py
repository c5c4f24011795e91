"""The import of the toppra package is deferred until an attribute of it is used."""

import subprocess
import sys

SCRIPT = """
import sys
import planning.retime.toppra.toppra_passes
print("matplotlib" in sys.modules)
import toppra
path = toppra.SplineInterpolator([0, 1], [[0.0], [1.0]])
limit = toppra.constraint.JointVelocityConstraint([2.0])
motion = toppra.algorithm.TOPPRA([limit], path, parametrizer="ParametrizeConstAccel")
print(motion.compute_trajectory().duration, toppra.algorithm.algorithm.plt.figure.__name__)
try:
    toppra.nothing
except AttributeError as error:
    print(error)
"""


def test_nothing_is_loaded_to_draw_with_until_all_of_toppra_is_wanted() -> None:
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", SCRIPT], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    early, used, missing = done.stdout.splitlines()
    assert early == "False"
    duration, figure = used.split()
    assert 0.5 <= float(duration) < 0.6
    assert figure == "figure"
    assert "no attribute 'nothing'" in missing
