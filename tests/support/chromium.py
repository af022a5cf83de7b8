"""One Chromium, and one tab of it, for all pages that a process of tests opens: another process takes longer than most
pages do.

Does: opens a page, without what earlier pages stored, and says what an expression is there.
Assumes: POSIX, where a program finds the two ends of its pipe as files 3 and 4.
Does not: know what the pages are.
"""

import atexit
import json
import os
import select
import shutil
import subprocess
import tempfile
import time

COMMAND = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
QUIETLY = ("--headless", "--no-sandbox", "--disable-gpu")
SECONDS = 300


class Chromium:
    """A browser that is asked over a pipe, message by message (Chrome DevTools Protocol)."""

    def __init__(self) -> None:
        assert COMMAND is not None, "chromium is not installed"
        self._user = tempfile.TemporaryDirectory(prefix="maviper-chromium-", ignore_cleanup_errors=True)
        (to_read, self._to_write), (self._from, from_write) = os.pipe(), os.pipe()
        options = [*QUIETLY, "--allow-file-access-from-files", f"--user-data-dir={self._user.name}"]
        # the shell gives the pipes their numbers, whichever they have here
        script = f'exec "$@" 3<&{to_read} 4>&{from_write} {to_read}<&- {from_write}>&-'
        self._process = subprocess.Popen(
            ["bash", "-c", script, "bash", COMMAND, *options, "--remote-debugging-pipe"],
            pass_fds=(to_read, from_write),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(to_read)
        os.close(from_write)
        self._asked, self._heard = 0, b""
        atexit.register(self.close)
        target = self._ask("Target.createTarget", url="about:blank")["targetId"]
        self._tab = self._ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self._ask("Page.enable", self._tab)

    def close(self) -> None:
        """Ends the browser and removes what it stored."""
        os.close(self._to_write)  # it ends by itself then
        self._process.wait(timeout=SECONDS)
        os.close(self._from)
        self._user.cleanup()

    def evaluated(self, address, expression):
        """What an expression, or what it promises, is in a page once it is loaded, as JSON would say it."""
        self._ask("Storage.clearDataForOrigin", self._tab, origin="file://", storageTypes="all")
        self._ask("Page.navigate", self._tab, url=address)
        self._wait(lambda told: told.get("method") == "Page.loadEventFired" and told.get("sessionId") == self._tab)
        found = self._ask("Runtime.evaluate", self._tab, expression=expression, returnByValue=True, awaitPromise=True)
        self._ask("Page.navigate", self._tab, url="about:blank")  # a page goes on drawing
        assert "exceptionDetails" not in found, found["exceptionDetails"]
        return found["result"]["value"]

    def _ask(self, method, session=None, **params):
        self._asked += 1
        number = self._asked
        message = {"id": number, "method": method, "params": params} | ({"sessionId": session} if session else {})
        waiting = json.dumps(message).encode() + b"\0"
        while waiting:
            waiting = waiting[os.write(self._to_write, waiting) :]
        answer = self._wait(lambda told: told.get("id") == number)
        assert "result" in answer, (method, answer)
        return answer["result"]

    def _wait(self, wanted):
        """The first message that is wanted; others are of no use here."""
        end = time.monotonic() + SECONDS
        while True:
            while b"\0" in self._heard:
                first, _, self._heard = self._heard.partition(b"\0")
                told = json.loads(first)
                if wanted(told):
                    return told
            ready, _, _ = select.select([self._from], [], [], max(0.0, end - time.monotonic()))
            more = os.read(self._from, 1 << 16) if ready else b""
            assert more, "chromium said nothing any more"
            self._heard += more
