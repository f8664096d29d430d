"""Drives headless Chromium over a pipe (--remote-debugging-pipe): no port is opened, nothing but the standard library is used.
What the page asked for, said on the console, and dialogs it opened are kept."""
import base64
import json
import os
import select
import shutil
import subprocess
import tempfile
import time


class Browser:
    def __init__(self):
        self.folder = tempfile.mkdtemp(prefix="matrig-browser.")
        to_read, self.to_browser = os.pipe()
        self.from_browser, to_write = os.pipe()

        def place():  # the browser reads commands from 3 and writes to 4
            read, write = os.dup(to_read), os.dup(to_write)
            high = [os.dup2(read, 200), os.dup2(write, 201)]
            os.dup2(high[0], 3)
            os.dup2(high[1], 4)

        self.process = subprocess.Popen(
            ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking",
             "--disable-component-update", "--disable-sync", "--disable-default-apps", "--remote-debugging-pipe", "--hide-scrollbars",
             "--user-data-dir=" + self.folder, "about:blank"],
            preexec_fn=place, close_fds=False, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_read)
        os.close(to_write)
        self.buffer, self.number, self.answers = b"", 0, {}
        self.requests, self.errors, self.dialogs = [], [], []
        target = self.call("Target.createTarget", {"url": "about:blank"})["targetId"]
        self.session = None
        self.session = self.call("Target.attachToTarget", {"targetId": target, "flatten": True})["sessionId"]
        for domain in ("Runtime", "Log", "Page", "Network"):
            self.call(domain + ".enable")

    def send(self, method, parameters=None):
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters or {}}
        if getattr(self, "session", None):
            message["sessionId"] = self.session
        os.write(self.to_browser, json.dumps(message).encode() + b"\0")
        return self.number

    def take(self, wait_s):
        """One message from the browser into its place. False: none came."""
        while b"\0" not in self.buffer:
            if not select.select([self.from_browser], [], [], wait_s)[0]:
                return False
            piece = os.read(self.from_browser, 1 << 20)
            if not piece:
                raise RuntimeError("the browser is gone")
            self.buffer += piece
        text, self.buffer = self.buffer.split(b"\0", 1)
        message = json.loads(text)
        method, said = message.get("method"), message.get("params", {})
        if "id" in message:
            self.answers[message["id"]] = message
        elif method == "Network.requestWillBeSent":
            self.requests.append(said["request"]["url"])
        elif method == "Runtime.exceptionThrown":
            self.errors.append("exception: " + json.dumps(said["exceptionDetails"])[:400])
        elif method == "Runtime.consoleAPICalled" and said["type"] in ("error", "warning", "assert"):
            self.errors.append("console: " + json.dumps(said["args"])[:400])
        elif method == "Log.entryAdded" and said["entry"]["level"] in ("error", "warning"):
            self.errors.append("log: %s %s" % (said["entry"]["text"], said["entry"].get("url", "")))
        elif method == "Page.javascriptDialogOpening":
            self.dialogs.append(said["message"])
            self.send("Page.handleJavaScriptDialog", {"accept": False})
        return True

    def call(self, method, parameters=None, wait_s=100):
        number, until = self.send(method, parameters), time.monotonic() + wait_s
        while number not in self.answers:
            if time.monotonic() > until or not self.take(wait_s):
                raise RuntimeError("no answer to " + method)
        answer = self.answers.pop(number)
        if "error" in answer:
            raise RuntimeError("%s: %s" % (method, answer["error"]))
        return answer["result"]

    def pump(self):
        while self.take(0):
            pass

    def js(self, expression):
        result = self.call("Runtime.evaluate", {"expression": expression, "returnByValue": True, "awaitPromise": True})
        if "exceptionDetails" in result:
            raise RuntimeError("%s: %s" % (expression[:80], json.dumps(result["exceptionDetails"])[:400]))
        return result["result"].get("value")

    def wait(self, expression, wait_s=15):
        """Until the expression is true; its value, or None after wait_s."""
        until = time.monotonic() + wait_s
        while time.monotonic() < until:
            value = self.js(expression)
            if value:
                return value
            time.sleep(0.05)
        return None

    def open(self, url, width=1120, height=1600, theme="light"):
        self.size(width, height)
        self.call("Emulation.setEmulatedMedia", {"media": "screen", "features": [{"name": "prefers-color-scheme", "value": theme}]})
        self.call("Page.navigate", {"url": url})
        self.wait("document.readyState === 'complete'")

    def size(self, width, height):
        self.call("Emulation.setDeviceMetricsOverride", {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})

    def media(self, media, theme="light"):
        self.call("Emulation.setEmulatedMedia", {"media": media, "features": [{"name": "prefers-color-scheme", "value": theme}]})

    def picture(self, path):
        data = self.call("Page.captureScreenshot", {"format": "png"}, 120)["data"]
        with open(path, "wb") as out:
            out.write(base64.b64decode(data))

    def key(self, key):
        code = {"Escape": 27, "Enter": 13, "Tab": 9}.get(key, ord(key[0].upper()))
        for kind in ("keyDown", "keyUp"):
            message = {"type": kind, "key": key, "windowsVirtualKeyCode": code}
            if len(key) == 1 and kind == "keyDown":
                message["text"] = key
            if key == "Enter" and kind == "keyDown":
                message["text"] = "\r"
            self.call("Input.dispatchKeyEvent", message)

    def close(self):
        try:
            self.session = None
            self.send("Browser.close")
            self.process.wait(10)
        except Exception:  # it is ended in any case
            self.process.kill()
            self.process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)


class Tap:
    """Tests in TAP, for tests/run-all.sh."""

    def __init__(self):
        self.tests = self.failed = 0

    def check(self, name, good, *details):
        self.tests += 1
        print("%s %d - %s" % ("ok" if good else "not ok", self.tests, name), flush=True)
        if not good:
            self.failed += 1
            for detail in details:
                print("# " + str(detail)[:1500].replace("\n", "\n# "), flush=True)
        return good

    def end(self):
        print("1..%d" % self.tests)
        return 1 if self.failed else 0
