"""Samples: a plan may deliver what `?period=` may ask for later."""

import pytest
from pydantic import TypeAdapter, ValidationError

from service.plans.delivery.routes import Period
from service.plans.models.request import Retime


@pytest.mark.parametrize(("period", "is_allowed"), [(1e-4, True), (9e-5, False), (10.1, False)])
def test_a_plan_and_its_trajectory_allow_the_same_periods(period: float, is_allowed: bool) -> None:
    asked = [
        lambda: Retime.model_validate({"sample_period": period}),
        lambda: TypeAdapter(Period.__value__).validate_python(period),
    ]
    for ask in asked:
        if is_allowed:
            ask()
        else:
            with pytest.raises(ValidationError):
                ask()
