"""Runs on several workers, one of which is lost, and runs again and again in one process."""

import gc
import os
import signal
import sys
import time

import numpy as np
import pytest

import willis

BROKEN = "data/broken-circle-of-willis.swc"


def one_subject(path):
    time.sleep(0.5)
    return willis.infer(path, samples=256, threads=1, progress=False)


@pytest.fixture
def client(monkeypatch):
    distributed = pytest.importorskip("dask.distributed")
    monkeypatch.setenv("DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT", "30s")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            yield client


def gathered_with_a_worker_lost(client, function, inputs):
    futures = [client.submit(function, one, pure=False) for one in inputs]
    victim = next(iter(client.run(os.getpid).values()))
    os.kill(victim, signal.SIGKILL)
    return client.gather(futures), victim


def test_subjects_on_workers_of_which_one_is_killed(client):
    inputs = [BROKEN, *(f"data/circle-of-willis/{name}" for name in sorted(os.listdir("data/circle-of-willis")) if name.endswith(".graphml"))][:4]
    runs, _ = gathered_with_a_worker_lost(client, one_subject, inputs)
    for path, run in zip(inputs, runs):
        assert run.edges["likelihood"].tobytes() == one_subject(path).edges["likelihood"].tobytes()


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_memory_of_repeated_runs_is_flat():
    def resident():
        gc.collect()
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")

    scan = willis.read(BROKEN)

    def again(times):
        for _ in range(times):
            run = willis.infer(scan, samples=512, progress=False)
            assert np.isfinite(run.likelihood.data).all() and run.topology.n_edges
        return resident()

    # What allocators hold settles first; then a leak of one table a run, some 20 kB, would be 2 MB.
    before = again(100)
    assert again(100) - before < 1 << 20
