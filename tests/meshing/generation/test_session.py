"""gmsh within a process that does other things too: threads, and handlers of signals."""

from __future__ import annotations

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

from meshing import NotchedBeam
from meshing.generation.sizes import MeshSizes

#: gmsh first starts in a thread; then the process meets signals that it had asked to be spared
WORKER = """
import faulthandler, os, signal, threading
faulthandler.enable()
from meshing import NotchedBeam
from meshing.generation.sizes import MeshSizes
signal.signal(signal.SIGHUP, lambda *_: print("hung up", flush=True))
worker = threading.Thread(target=lambda: NotchedBeam(100.0, 80.0, 20.0, 10.0, 5.0).mesh(MeshSizes(5.0, 10.0)))
worker.start(); worker.join()
os.kill(os.getpid(), signal.SIGHUP)
reading, writing = os.pipe()
os.close(reading)
try:
    os.write(writing, b"x")
except BrokenPipeError:
    print("broken pipe", flush=True)
os.kill(os.getpid(), signal.SIGFPE)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_the_process_keeps_its_handlers_of_signals() -> None:
    """A broken pipe is an exception, not the end, and a floating-point fault is reported by who was asked to."""
    ended = subprocess.run([sys.executable, "-c", WORKER], capture_output=True, text=True, timeout=120)
    assert ended.stdout.split("\n")[:2] == ["hung up", "broken pipe"]
    assert "Fatal Python error: Floating point exception" in ended.stderr


def test_threads_mesh_one_after_another() -> None:
    """As often as not, two at a time would end the interpreter."""

    def points(size: float) -> list[list[float]]:
        return NotchedBeam(100.0, 80.0, 20.0, 10.0, 5.0).mesh(MeshSizes(size, 10.0)).points.tolist()

    sizes = [4.0, 5.0, 6.0, 7.0] * 3
    alone = {size: points(size) for size in sizes[:4]}
    with ThreadPoolExecutor(4) as threads:
        assert list(threads.map(points, sizes)) == [alone[size] for size in sizes]
