"""What the benchmark of the service tells is what there was, and what failed is told as such."""

import json
import math

import httpx
import pytest

from benchmarks.service import main
from benchmarks.service_load.boxes import boxes, scene_of
from benchmarks.service_load.host import Host, timed
from benchmarks.service_load.loads import read
from benchmarks.service_load.measure import Measure, quantile
from tests.profiles import only_campaign


@pytest.mark.campaign
@only_campaign("a server starts, and locust: 20 s")
def test_everything_is_measured(capsys) -> None:
    assert main(["--quick", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    for one in told:
        assert (one["mebibytes"] or one["ms"]["median"]) > 0, one
        assert one["done"] > 0 or one["what"].startswith("memory")
    assert len({one["what"] for one in told}) == len(told) == 28


class Answering(Host):
    """A host whose server is a function."""

    def __init__(self, answer) -> None:
        super().__init__(limit=1.0)
        self.num_dropped = 0
        self.http = httpx.Client(base_url="http://x", transport=httpx.MockTransport(answer))

    def need(self) -> None:
        """There is always one."""

    def drop(self) -> None:
        self.num_dropped += 1


def never(request):
    raise httpx.ReadTimeout("slow", request=request)


def refuses(request):
    return httpx.Response(503, json={"code": "deadline_exceeded"}, request=request)


def test_what_does_not_end_or_is_refused_is_told() -> None:
    with Answering(never) as host:
        loaded, moved = boxes(host, [1000], 1.0)
        assert "no answer in" in loaded.faults[0]
        assert moved.faults == ["it was not posted"]
        assert host.num_dropped == 1
        assert loaded.cells()[2:6] == ["-"] * 4
        assert loaded.plain()["ms"]["median"] is None
    with Answering(refuses) as host:
        measure = Measure("x")
        assert timed(measure, host, lambda: host.post("/v1/scenes")) is None
        assert measure.faults[0].startswith("503 deadline_exceeded after")
        assert host.num_dropped == 0


def test_locusts_numbers_are_read() -> None:
    times = {"10": 3, "9": 1, "120.0": 1}
    told = {"num_requests": 5, "num_failures": 2, "response_times": times}
    measure = read(Measure("x"), {**told, "start_time": 100.0, "last_request_timestamp": 102.0})
    assert measure.seconds == pytest.approx([0.009, 0.01, 0.01, 0.01, 0.12])
    assert measure.rate == 1.5
    assert len(measure.faults) == 2


def test_quantiles_are_linear_between_ranks() -> None:
    assert math.isnan(quantile([], 0.5))
    assert quantile([4.0], 0.95) == 4.0
    assert quantile([3.0, 1.0, 2.0, 4.0], 0.5) == 2.5
    assert quantile([0.0, 10.0, 20.0], 0.95) == 19.0
    assert quantile([0.0, 10.0, 20.0], 1.0) == 20.0


@pytest.mark.parametrize("size", [1, 10, 1000])
def test_boxes_do_not_touch(size: int) -> None:
    objects = scene_of(size)["objects"]
    assert len(objects) == size
    assert len({tuple(round(x, 6) for x in one["pose"]["position"]) for one in objects}) == size
