"""Numbers of forms: what a field shows, as the page rounds and bounds it, is what is asked."""

import math

import pytest
import viser
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from service.studio import emptied, front, watch
from service.studio.editing.object_form import ObjectForm
from service.studio.forms.fields import Number, Vector
from service.studio.forms.inputs import single

REPEATED = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
TYPED = st.one_of(st.floats(-1e7, 1e7), st.floats(-2.0, 2.0), st.sampled_from([0.0, 4e-7, -3.0]))
BOUNDS = [
    (None, None, False),
    (0.0, 10.0, False),
    (0.0, 3600.0, True),
    (1e-5, 3.0, False),
    (-1e6, 1e6, False),
]


@pytest.fixture(scope="module")
def gui():
    server = viser.ViserServer("127.0.0.1", 0, verbose=False)
    yield server.gui
    server.stop()


def left(handle, value, which=None):
    """What a field shows that was typed in and left: viser's page rounds, then bounds."""
    low, high = (bound if which is None or bound is None else bound[which] for bound in
                 (handle.min, handle.max))  # fmt: skip
    shown = round(value, handle.precision)
    shown = shown if low is None else max(low, shown)
    return shown if high is None else min(high, shown)


def newest(gui):
    return [*gui._gui_input_handle_from_uuid.values()][-1]


@REPEATED
@given(value=TYPED, bounds=st.sampled_from(BOUNDS), default=st.sampled_from([None, 0.5, 1.0]))
def test_a_number_that_a_field_shows_is_asked(gui, value, bounds, default):
    field = Number("x", "", default, False, *bounds, is_whole=False)
    made = single(gui, field, (), lambda: None)
    handle = newest(gui)
    handle.value = float(left(handle, value))
    assert made.value() == handle.value
    assert round(handle.value, handle.precision) == handle.value
    made.remove()


@REPEATED
@given(value=st.tuples(TYPED, TYPED, TYPED), bounds=st.sampled_from(BOUNDS))
def test_three_numbers_that_a_field_shows_are_asked(gui, value, bounds):
    made = single(gui, Vector("x", "", None, False, *bounds), (), lambda: None)
    handle = newest(gui)
    handle.value = tuple(float(left(handle, x, i)) for i, x in enumerate(value))
    assert tuple(made.value()) == handle.value
    made.remove()


def test_what_a_field_is_filled_with_is_shown_to_the_millionth(gui):
    for field in (Number("x", "", 1.0, False, None, None, False, is_whole=False),
                  Vector("x", "", None, False, None, None, False)):  # fmt: skip
        made = single(gui, field, (), lambda: None)
        made.fill(math.pi / 6 if isinstance(field, Number) else [math.pi / 6] * 3)
        handle = newest(gui)
        assert round(math.pi / 6, handle.precision) == pytest.approx(math.pi / 6, abs=1e-6)
        made.remove()


def test_a_place_of_an_object_is_shown_to_the_micrometre(gui):
    before = {*gui._gui_input_handle_from_uuid}
    ObjectForm(gui, lambda: None)
    made = [h for uuid, h in gui._gui_input_handle_from_uuid.items() if uuid not in before]
    numbers = [handle for handle in made if hasattr(handle, "precision")]
    assert len(numbers) == 5
    assert all(handle.precision == 6 for handle in numbers)


def test_the_page_has_what_brings_back_an_emptied_number_once():
    page = front._read_page()
    assert page.count(emptied.SCRIPT) == page.count(watch.SCRIPT) == 1
