"""A sweep on Ray: the same bytes, with a worker killed in the midst."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

import palpate

ray = pytest.importorskip("ray")


@pytest.fixture
def cluster() -> Iterator[None]:
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    yield
    ray.shutdown()


def test_a_cluster_of_ray_whose_worker_dies_writes_the_same_table(cluster: None, tmp_path: Path) -> None:
    grid = {"seed": range(1, 201)}
    alone, out = tmp_path / "alone.jsonl", tmp_path / "runs.jsonl"
    palpate.sweep("sphere-along", grid, out=alone)
    victim = ray.get(ray.remote(lambda: os.getpid()).remote())
    assert victim != os.getpid()

    def kill() -> None:
        while not out.exists() or out.read_bytes().count(b"\n") < 20:
            time.sleep(0.005)
        os.kill(victim, signal.SIGKILL)

    killer = threading.Thread(target=kill)
    killer.start()
    palpate.sweep("sphere-along", grid, executor=palpate.RayExecutor(), out=out)
    killer.join()
    assert out.read_bytes() == alone.read_bytes()
