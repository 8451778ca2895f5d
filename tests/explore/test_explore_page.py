"""The page of `cohesive explore` in a headless browser, which is driven by its own protocol."""

from __future__ import annotations

import asyncio
import base64
import json
import shutil
import subprocess
import threading
import time
import urllib.request
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cohesive import Scene
from cohesive.explore.explorer import Explorer
from cohesive.explore.server import ExploreServer

BROWSER = shutil.which("chromium") or shutil.which("google-chrome")
pytestmark = [pytest.mark.slow, pytest.mark.skipif(BROWSER is None, reason="no chromium or google-chrome on this machine")]

#: moves a slider and waits until what is said of the run is another; milliseconds that took
MOVE = """
new Promise(done => {
  const slider = document.querySelectorAll('input[type=range]')[%d], said = document.getElementById('said');
  const before = said.textContent, began = performance.now();
  new MutationObserver((_, watching) => {
    if (said.textContent !== before) { watching.disconnect(); done(performance.now() - began); }
  }).observe(said, {childList: true, characterData: true, subtree: true});
  slider.value = %r; slider.dispatchEvent(new Event('input'));
})
"""


class Page:
    """A tab of the browser."""

    def __init__(self, socket: Any) -> None:
        self._socket, self._numbers = socket, count(1)

    async def ask(self, method: str, **parameters: Any) -> dict[str, Any]:
        number = next(self._numbers)
        await self._socket.write_message(json.dumps({"id": number, "method": method, "params": parameters}))
        while True:
            answer = json.loads(await asyncio.wait_for(self._socket.read_message(), 30))
            if answer.get("id") == number:
                assert "error" not in answer, answer
                return dict(answer["result"])

    async def value(self, expression: str) -> Any:
        answered = await self.ask("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in answered, answered
        return answered["result"].get("value")

    async def picture(self, path: Path) -> bytes:
        data = base64.b64decode((await self.ask("Page.captureScreenshot"))["data"])
        path.write_bytes(data)
        return data

    async def until(self, expression: str) -> None:
        for _ in range(200):
            if await self.value(expression):
                return
            await asyncio.sleep(0.05)
        raise AssertionError(f"{expression} does not come")


@pytest.fixture
def address() -> Iterator[str]:
    server = ExploreServer(Explorer(Scene.load("notched-beam")))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield server.address
    server.shutdown()
    server.server_close()


@pytest.fixture
def port(tmp_path: Path) -> Iterator[int]:
    folder = tmp_path / "profile"
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-quic"]
    options += ["--no-first-run", "--disable-component-update", "--disable-sync", "--window-size=1400,900"]
    command = [str(BROWSER), *options, "--remote-debugging-port=0", f"--user-data-dir={folder}"]
    browser = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        for _ in range(200):
            if (folder / "DevToolsActivePort").exists():
                break
            time.sleep(0.1)
        yield int((folder / "DevToolsActivePort").read_text().split()[0])
    finally:
        browser.kill()
        browser.wait()


@asynccontextmanager
async def opened(port: int, address: str) -> AsyncIterator[Page]:
    from tornado.websocket import websocket_connect

    request = urllib.request.Request(f"http://127.0.0.1:{port}/json/new?{address}", method="PUT")
    with urllib.request.urlopen(request, timeout=30) as answer:
        tab = json.load(answer)
    socket = await websocket_connect(tab["webSocketDebuggerUrl"], max_message_size=2**26)
    page = Page(socket)
    await page.until("document.getElementById('said') && document.getElementById('said').textContent.includes('ms')")
    yield page
    socket.close()
    await socket.read_message()  # None: closed


def test_a_moved_slider_redraws_within_four_tenths_of_a_second(port: int, address: str, tmp_path: Path) -> None:
    """In the median of moves of E, ft and Gf, with a run of the default beam for each; the picture is another one then."""

    async def moved() -> list[float]:
        took = []
        async with opened(port, address) as page:
            before = await page.picture(tmp_path / "before.png")
            for slider in (0, 1, 2):
                name = f"document.querySelectorAll('input[type=range]')[{slider}]"
                low, high = [float(await page.value(f"{name}.{end}")) for end in ("min", "max")]
                for share in (0.4, 0.55, 0.5):
                    took.append(float(await page.value(MOVE % (slider, str(low + share * (high - low))))))
            assert await page.picture(tmp_path / "after.png") != before
        return took

    took = asyncio.run(moved())
    assert np.median(took) < 400.0, took


def test_a_fit_starts_from_the_curve_of_the_scene_and_its_result_stays(port: int, address: str, tmp_path: Path) -> None:
    """With intervals, in a place of its own, whatever is moved afterwards; the measured band is drawn from the start."""

    async def fitted() -> tuple[str, str]:
        async with opened(port, address) as page:
            assert await page.value("measured.over + measured.curves.length + $('fit').disabled") == "opening1false"
            await page.value("$('fit').click(); 0")
            await page.until("!$('result').hidden && $('said').textContent.includes('ms')")
            before = await page.value("$('fitted').textContent")
            await page.value(MOVE % (1, "1.5"))
            await page.picture(tmp_path / "fitted.png")
            assert await page.value("$('error').textContent") == ""
            return before, await page.value("$('fitted').textContent")

    before, after = asyncio.run(fitted())
    assert before == after and "intervals of 95 %" in after and "material.Gf" in after


def test_two_tabs_and_a_run_that_fails_leave_the_page_alive(port: int, address: str) -> None:
    async def both() -> None:
        async with opened(port, address) as one, opened(port, address) as other:
            said = await other.value("document.getElementById('said').textContent")
            await one.value(MOVE % (1, "1.5"))
            assert await other.value("document.getElementById('said').textContent") == said
            await one.value("values['material.ft'] = -1; ask(); 0")
            await one.until("document.getElementById('error').textContent.includes('material.ft')")
            await one.value(MOVE % (1, "1.0"))
            assert await one.value("document.getElementById('error').textContent") == ""

    asyncio.run(both())
