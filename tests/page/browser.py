# SPDX-License-Identifier: Apache-2.0
"""A headless chromium, driven by the DevTools protocol through two pipes: messages of
JSON, each ended by a null byte (--remote-debugging-pipe)."""
import base64
import fcntl
import json
import os
import select
import shutil
import subprocess
import tempfile
import time
import urllib.parse


def find():
    """The path of a chromium, or None."""
    for name in ("chromium", "chromium-browser", "google-chrome"):
        if shutil.which(name):
            return shutil.which(name)
    return None


class Browser:
    def __init__(self):
        pipes = [os.pipe(), os.pipe()]
        to, back = (fcntl.fcntl(fd, fcntl.F_DUPFD, 20) for fd in (pipes[0][0], pipes[1][1]))
        self.out, self.back = pipes[0][1], pipes[1][0]
        os.close(pipes[0][0])
        os.close(pipes[1][1])
        self.folder = tempfile.mkdtemp(prefix="glarepp-page.")
        # (a shell puts the pipes where chromium looks for them: 3 and 4)
        self.process = subprocess.Popen(
            ["bash", "-c", f'exec "$@" 3<&{to} 4>&{back}', "bash", find(),
             "--headless=new", "--remote-debugging-pipe", "--no-sandbox", "--disable-gpu",
             "--disable-dev-shm-usage", "--no-first-run", "--hide-scrollbars",
             "--allow-file-access-from-files", f"--user-data-dir={self.folder}"],
            pass_fds=(to, back), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            env={**os.environ, "HOME": self.folder})
        os.close(to)
        os.close(back)
        self.number, self.buffer, self.session = 0, b"", None
        self.messages = []  # of the console, and uncaught errors
        self.loads = 0  # documents that have been loaded

    def close(self):
        try:
            self.send("Browser.close", session=None)
            self.process.wait(10)
        except (OSError, RuntimeError, subprocess.TimeoutExpired):
            self.process.kill()
        shutil.rmtree(self.folder, ignore_errors=True)

    def read(self, until):
        while b"\0" not in self.buffer:
            left = until - time.monotonic()
            if left <= 0 or not select.select([self.back], [], [], left)[0]:
                raise RuntimeError("chromium does not answer")
            more = os.read(self.back, 1 << 20)
            if not more:
                raise RuntimeError("chromium has ended")
            self.buffer += more
        line, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(line)

    def hear(self, event):
        """Keeps what a page says: each message fails the tests."""
        p = event.get("params", {})
        if event.get("method") == "Page.loadEventFired":
            self.loads += 1
        elif event.get("method") == "Runtime.consoleAPICalled":
            self.messages.append(" ".join(str(a.get("value", a.get("description")))
                                          for a in p["args"]))
        elif event.get("method") == "Runtime.exceptionThrown":
            d = p["exceptionDetails"]
            self.messages.append(d.get("exception", {}).get("description", d["text"]))
        elif event.get("method") == "Log.entryAdded":
            self.messages.append(p["entry"]["text"])

    def send(self, method, session=True, wait=30, **params):
        self.number += 1
        message = {"id": self.number, "method": method, "params": params}
        if session and self.session:
            message["sessionId"] = self.session
        self.write(json.dumps(message).encode() + b"\0")
        until = time.monotonic() + wait
        while True:
            answer = self.read(until)
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']['message']}")
                return answer["result"]
            self.hear(answer)

    def write(self, data):
        while data:
            data = data[os.write(self.out, data):]

    def open(self, path, width=1600, height=1000, dark=False, scale=1):
        """Opens a file in a new tab; returns the seconds that its thread worked until
        it shows pictures: those of a clock depend on who else works."""
        if self.session:
            self.send("Target.closeTarget", session=False, targetId=self.target)
            self.session = None
        self.messages = []
        self.target = self.send("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.send("Target.attachToTarget", targetId=self.target,
                                 flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "DOM"):
            self.send(f"{domain}.enable")
        self.resize(width, height, scale)
        self.dark(dark)
        self.send("Performance.enable", timeDomain="threadTicks")
        self.send("Page.navigate", url="file://" + urllib.parse.quote(os.path.abspath(path)))
        self.wait("document.body && document.body.dataset.ready !== undefined")
        self.settle()
        return next(m["value"] for m in self.send("Performance.getMetrics")["metrics"]
                    if m["name"] == "TaskDuration")

    def resize(self, width, height, scale=1):
        self.send("Emulation.setDeviceMetricsOverride", width=width, height=height,
                  deviceScaleFactor=scale, mobile=False)

    def dark(self, on):
        self.send("Emulation.setEmulatedMedia", features=[
            {"name": "prefers-color-scheme", "value": "dark" if on else "light"}])

    def run(self, code):
        """The value of an expression, or of the promise that it gives."""
        answer = self.send("Runtime.evaluate", expression=code, returnByValue=True,
                           awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(answer["exceptionDetails"]["exception"]["description"])
        return answer["result"].get("value")

    def wait(self, condition, seconds=20):
        until = time.monotonic() + seconds
        while not self.run(f"!!({condition})"):
            if time.monotonic() > until:
                raise RuntimeError(f"waited {seconds} s for {condition}: {self.messages}")
            time.sleep(0.02)

    def follow(self, selector, end):
        """Clicks a link and waits until the page whose address ends so shows something.
        (A page that is just going answers nothing: it is asked when the next has come.)"""
        before, until = self.loads, time.monotonic() + 20
        self.run(f"void setTimeout(() => document.querySelector({json.dumps(selector)}).click())")
        while self.loads == before:
            self.hear(self.read(until))
        self.wait(f"location.href.endsWith({json.dumps(end)}) && document.body.dataset.ready")

    def settle(self):
        """Waits until what was asked for is drawn."""
        self.run("new Promise(r => requestAnimationFrame(() => requestAnimationFrame(r)))")

    def key(self, key, shift=False):
        codes = {"ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39, "ArrowDown": 40,
                 "Tab": 9, "Enter": 13, "Escape": 27, " ": 32}
        text = "\r" if key == "Enter" else key if len(key) == 1 else None
        p = {"key": key, "code": key, "windowsVirtualKeyCode": codes.get(key, 0),
             "modifiers": 8 if shift else 0}
        if text:
            p["text"] = text
        self.send("Input.dispatchKeyEvent", type="keyDown", **p)
        self.send("Input.dispatchKeyEvent", type="keyUp", **p)
        self.settle()

    def mouse(self, kind, x, y, buttons=0):
        self.send("Input.dispatchMouseEvent", type=kind, x=x, y=y, buttons=buttons,
                  button="left" if buttons or kind == "mouseReleased" else "none",
                  clickCount=1 if kind in ("mousePressed", "mouseReleased") else 0)

    def box(self, selector):
        return self.run(f"(b => [b.left, b.top, b.width, b.height])"
                        f"(document.querySelector({json.dumps(selector)}).getBoundingClientRect())")

    def picture(self, path, whole=True):
        size = self.run("[document.documentElement.scrollWidth, document.documentElement.scrollHeight]")
        shot = self.send("Page.captureScreenshot", format="png", captureBeyondViewport=whole,
                         **({"clip": {"x": 0, "y": 0, "width": size[0], "height": min(size[1], 6000),
                                      "scale": 1}} if whole else {}))
        with open(path, "wb") as f:
            f.write(base64.b64decode(shot["data"]))
