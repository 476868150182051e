"""A cluster of dask's own commands on the loopback interface, and what it loses on the way."""

from __future__ import annotations

import time

import numpy as np
import pytest

import pmmkit as pk
from pmmkit.base import each, opened
from scripts.datasets.make_large import make
from scripts.studies.cluster import cluster, kill, timed

pytest.importorskip("distributed", reason="dask.distributed is not installed")
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("campaign")
    make(place, runs=24, mb=0.03)
    return place


def test_a_cluster_gives_the_same_to_the_bit_also_when_a_worker_or_the_scheduler_is_killed(folder):
    _, here = timed(folder, 1)
    with cluster(2) as machines:
        _, there = timed(folder, machines.address)
        assert there == here
        _, half = timed(folder, machines.address, lambda: kill(machines.workers[0]))
        assert half == here
        ships = {"speed": 7.97, "rudder_deg": 35, "spread": 0.05, "n": 2600}
        with opened(machines.address) as executor:
            far = pk.monte_carlo("kvlcc2", executor=executor, **ships)
        near = pk.monte_carlo("kvlcc2", **ships)
        assert far.failed == near.failed
        for name, values in near.metrics.items():
            assert np.array_equal(far.metrics[name], values, equal_nan=True)

        def slowly(k):
            time.sleep(0.1)
            return k

        done, names = {}, [f"thing {k}" for k in range(20)]
        with opened(machines.address) as executor:
            for place, result in each(slowly, range(20), executor, names=names):
                done[place] = result
                if len(done) == 3:
                    kill(machines.scheduler)
        assert done == {k: k for k in range(20)}
