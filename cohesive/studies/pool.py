"""Many runs at once: in processes of this machine, or on a Dask cluster with the optional package distributed."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
from collections.abc import Iterable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager

from ..algebra import threads
from ..errors import NotConverged, SceneError
from ..outcome.result import Result
from ..scenes.scene import Scene
from ..simulation import run

#: what a process that cannot run means, as a rule
NOT_STARTED = (
    "a process for the runs ended by itself. If it did so at once: each starts by importing the script, which must call this "
    'below `if __name__ == "__main__":` and stand in a file; else memory was short. workers=1 needs no processes'
)


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
    with processes(executor) as pool:
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
def processes(given: Executor | None = None) -> Iterator[Executor]:
    """An executor with one process for each core, each task in a process of its own, unless one is given; what has not begun
    when it is left is cancelled."""
    if given is not None:
        yield given
        return
    pool = ProcessPoolExecutor(
        threads.cores(), multiprocessing.get_context("spawn"), initializer=_with_one_thread, max_tasks_per_child=1
    )
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)


@contextmanager
def workers(count: int) -> Iterator[Executor]:
    """An executor with `count` processes that live as long as it does. If it is left by an error, they are ended at once.

    Raises
    ------
    RuntimeError
        In a script that starts itself again in each of them.
    """
    script = sys.modules.get("__mp_main__")  # in one of the processes; its main module only once it has been imported
    if script is not None and script is not sys.modules["__main__"]:
        raise SystemExit(1)  # the first process tells
    before = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(count, multiprocessing.get_context("spawn"), initializer=_be_one_of_many)
    try:
        yield pool
    except BaseException as error:
        pool.shutdown(wait=False, cancel_futures=True)
        for process in set(multiprocessing.active_children()) - before:
            process.terminate()
        if isinstance(error, BrokenProcessPool):
            raise RuntimeError(NOT_STARTED) from error
        raise
    pool.shutdown()


def _with_one_thread() -> None:
    """The other cores have processes of their own."""
    os.environ[threads.VARIABLE] = "1"


def _be_one_of_many() -> None:
    """Ctrl-C reaches all processes of a terminal: what becomes of the runs is for the first one to say."""
    _with_one_thread()
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def dask_executor(address: str | None) -> Iterator[Executor | None]:
    """The executor of a Dask cluster: of the scheduler at `address`, or "local" for one worker on each core of this machine;
    without an address None.

    Each worker has one thread: the CPU time of a trial is that of its process.

    Raises
    ------
    SceneError
        Without distributed, with the command that installs it, or if no scheduler answers.
    """
    if address is None:
        yield None
        return
    try:
        from distributed import Client, LocalCluster
    except ImportError:
        raise SceneError(
            "--dask needs the package distributed, which is not installed: pip install 'cohesive-cracks[dask]'"
        ) from None
    if address == "local":
        with (
            LocalCluster(
                threads.cores(), threads_per_worker=1, dashboard_address=None, env={threads.VARIABLE: "1"}
            ) as cluster,
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
