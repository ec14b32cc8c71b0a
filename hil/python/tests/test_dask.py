"""A sweep on a cluster of Dask: the same bytes, with a worker killed in the midst."""

from __future__ import annotations

import os
import signal
import threading
import time
from pathlib import Path

import pytest

import palpate

distributed = pytest.importorskip("distributed")


def test_a_cluster_whose_worker_dies_writes_the_same_table(tmp_path: Path) -> None:
    grid = {"seed": range(1, 301)}
    alone, out = tmp_path / "alone.jsonl", tmp_path / "runs.jsonl"
    palpate.sweep("sphere-along", grid, out=alone)
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        pids = list(client.run(os.getpid).values())
        assert len(set(pids)) == 2

        def kill() -> None:
            while not out.exists() or out.read_bytes().count(b"\n") < 20:
                time.sleep(0.005)
            os.kill(pids[0], signal.SIGKILL)

        killer = threading.Thread(target=kill)
        killer.start()
        palpate.sweep("sphere-along", grid, executor=client.get_executor(), out=out)
        killer.join()
        assert pids[0] not in client.run(os.getpid).values()
    assert out.read_bytes() == alone.read_bytes()
