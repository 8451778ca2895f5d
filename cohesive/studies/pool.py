"""Trials on a Dask cluster, with the optional package distributed."""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager

from ..errors import SceneError


@contextmanager
def dask_executor(address: str) -> Iterator[Executor]:
    """The executor of a Dask cluster: of the scheduler at `address`, or "local" for one worker on each core of this machine.

    Workers of one thread each: the CPU time of a trial is that of its process.

    Raises
    ------
    SceneError
        Without distributed, with the command that installs it, or where no scheduler answers.
    """
    try:
        from distributed import Client, LocalCluster
    except ImportError:
        raise SceneError(
            "--dask needs the package distributed, which is not installed: pip install 'cohesive-cracks[dask]'"
        ) from None
    if address == "local":
        with (
            LocalCluster(os.cpu_count(), threads_per_worker=1, dashboard_address=None) as cluster,
            Client(cluster) as client,
        ):
            yield client.get_executor(pure=False)
        return
    try:
        client = Client(address, timeout=10)
    except (OSError, TimeoutError, ValueError) as error:
        raise SceneError(f"--dask {address}: no scheduler answers there ({error}); expected an address or 'local'") from None
    with client:
        yield client.get_executor(pure=False)
