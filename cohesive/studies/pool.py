"""Many runs at once: in processes of this machine, or on a Dask cluster with the optional package distributed."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Iterable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager, nullcontext

from ..errors import NotConverged, SceneError
from ..results.result import Result
from ..scenes.scene import Scene
from ..simulation import run


def run_all(scenes: Iterable[Scene], executor: Executor | None = None) -> Iterator[Result]:
    """Run scenes beside one another and yield their results in the order of the scenes.

    A run that stops early is yielded as far as it came; the last of its notes says why it stopped.

    Parameters
    ----------
    scenes : Scene each
    executor : runs the scenes, as that of a Dask client does; default: one process for each core. Several threads of one
        process would mesh at once, which gmsh does not allow.

    Raises
    ------
    SceneError, MeshError
        For bad input.
    NotConverged
        If not even one step of a run converged.
    """
    with processes() if executor is None else nullcontext(executor) as pool:
        futures = [pool.submit(run, scene) for scene in scenes]
        try:
            for future in futures:
                try:
                    result = future.result()
                except NotConverged as error:
                    if not isinstance(error.result, Result) or not error.result.steps:
                        raise
                    result = error.result
                yield result
        finally:
            for future in futures:
                future.cancel()


@contextmanager
def processes() -> Iterator[Executor]:
    """An executor with one process for each core, each task in a process of its own; what has not begun when it is left is
    cancelled."""
    pool = ProcessPoolExecutor(os.cpu_count(), multiprocessing.get_context("spawn"), max_tasks_per_child=1)
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)


@contextmanager
def dask_executor(address: str) -> Iterator[Executor]:
    """The executor of a Dask cluster: of the scheduler at `address`, or "local" for one worker on each core of this machine.

    Each worker has one thread: the CPU time of a trial is that of its process.

    Raises
    ------
    SceneError
        Without distributed, with the command that installs it, or if no scheduler answers.
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
