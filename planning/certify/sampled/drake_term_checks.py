"""Drake term checks: constraints of library users, evaluated on the certified motion itself.

The motion is written again as a B-spline in a fresh program, to which the user's function adds its
constraints; each is evaluated there. A constraint speaks of the instants where it was put only, so
nothing is proven between these.
"""

from typing import Any

import numpy as np
from pydrake.math import BsplineBasis, KnotVectorType
from pydrake.planning import KinematicTrajectoryOptimization
from pydrake.trajectories import BsplineTrajectory

from planning.certify.request import CertifyRequest
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.report.certificate import Check
from planning.domain.request.drake_term import DrakeTerm
from planning.world.drake_model import DrakeModel

# Order of the splines: cubic pieces.
_ORDER = 4
# Largest distance of a motion from its B-spline [rad or m].
_SPLINE_TOLERANCE = 1e-7
# Largest violation, in the units of the constraint.
_TOLERANCE = 1e-5


def drake_term_checks(model: DrakeModel, request: CertifyRequest) -> list[Check]:
    """Return one check per term: the largest violation of its constraints."""
    if not request.terms:
        return []
    spline = _as_bspline(request.trajectory)
    return [_check(i, term, spline, model) for i, term in enumerate(request.terms)]


def _check(
    index: int, term: DrakeTerm, spline: BsplineTrajectory | None, model: DrakeModel
) -> Check:
    """Return the check of a term; it fails where the motion is not a spline of the program."""
    name, where = f"drake term {index}: {term.name}", "sampled at the instants of its constraints"
    if spline is None:
        where = "the motion is not one of Drake's program"
        return Check(name, np.inf, _TOLERANCE, "1", np.inf, passed=False, where=where)
    trajopt = KinematicTrajectoryOptimization(spline)
    trajopt.SetInitialGuess(spline)
    program: Any = trajopt.get_mutable_prog()
    num_own = len(program.GetAllConstraints())
    term.add(trajopt, model.plant)
    violations = [_violation(program, b) for b in program.GetAllConstraints()[num_own:]]
    if not violations:
        where = "it has no constraints"
    worst = max(violations, default=0.0)
    passed = worst <= _TOLERANCE
    return Check(name, worst, _TOLERANCE, "1", np.inf, passed=passed, where=where)


def _violation(program: Any, binding: Any) -> float:
    """Return the largest violation of a constraint by the motion; infinite where it is unknown."""
    values = np.asarray(program.EvalBindingAtInitialGuess(binding), dtype=np.float64)
    bounds = binding.evaluator()
    excess = np.maximum(bounds.lower_bound() - values, values - bounds.upper_bound())
    worst = float(excess.max(initial=0.0))
    return worst if np.isfinite(values).all() else np.inf


def _as_bspline(trajectory: TimedTrajectory) -> BsplineTrajectory | None:
    """Return the clamped uniform cubic B-spline that a motion is, or None if it is none."""
    count, duration = trajectory.num_pieces + _ORDER - 1, trajectory.duration
    basis = BsplineBasis(_ORDER, count, KnotVectorType.kClampedUniform, 0.0, duration)
    unit: Any = BsplineTrajectory(basis, [row[:, None] for row in np.eye(count)])
    times = np.linspace(0.0, duration, 4 * count)
    matrix = unit.vector_values(times.tolist()).T
    targets = trajectory.positions(times)
    points = np.linalg.lstsq(matrix, targets)[0]
    if np.abs(matrix @ points - targets).max() > _SPLINE_TOLERANCE:
        return None
    return BsplineTrajectory(basis, [point[:, None] for point in points])
