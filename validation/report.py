#!/usr/bin/env python3
"""Looks at the page of a run as a person would, in headless Chromium, with nothing but Python's own library.

    undula run fsi3 --set time.end=1 -o out/fsi3
    report.py out/fsi3
    report.py out/fsi3 --pictures shots        # pictures of the page, 400 and 1600 pixels wide, light and dark

The page is opened from its file. Checked: no error in the console, no request to any network, all charts are drawn,
the player plays and steps by keys, and what it tells under the pointer is what the field file has there, for every
quantity, within 1 % of the value and 0.1 % of the largest one. How many moments a second are drawn is measured. The
exit code is 1 if anything is wrong. Values are compared of plane runs with `output.cells = "linear"` and
`output.mesh = "deformed"`, which are the defaults.
"""
import argparse
import base64
import json
import math
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import zlib
from array import array

BROWSERS = ["chromium", "chromium-browser", "google-chrome"]
# Without graphics processor, without requests of its own.
OPTIONS = ("--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
           "--disable-component-update --disable-sync --hide-scrollbars --remote-debugging-pipe").split()


class Browser:
    """Chromium, spoken to through two pipes: messages are JSON that ends with a zero byte."""

    def __init__(self, program):
        self.profile = tempfile.mkdtemp()
        to, self.to = os.pipe()
        self.answers, answers = os.pipe()

        def pipes():
            # The browser reads from 3 and writes to 4.
            read, write = os.dup(to), os.dup(answers)
            os.dup2(read, 3)
            os.dup2(write, 4)

        command = [program, *OPTIONS, f"--user-data-dir={self.profile}", "about:blank"]
        self.process = subprocess.Popen(command, preexec_fn=pipes, close_fds=False, stderr=subprocess.DEVNULL)
        os.close(to)
        os.close(answers)
        self.number, self.rest, self.events, self.session = 0, b"", [], None
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ["Page", "Runtime", "Log", "Network"]:
            self.ask(f"{domain}.enable")

    def ask(self, method, **params):
        self.number += 1
        message = {"id": self.number, "method": method, "params": params}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.to, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.message()
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]
            self.events.append(answer)

    def message(self):
        while b"\0" not in self.rest:
            more = os.read(self.answers, 1 << 20)
            if not more:
                raise RuntimeError("the browser has ended")
            self.rest += more
        text, self.rest = self.rest.split(b"\0", 1)
        return json.loads(text)

    def value(self, expression):
        """The value of JavaScript; promises are waited for."""
        answer = self.ask("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(f"{expression}: {answer['exceptionDetails']}")
        return answer["result"].get("value")

    def open(self, path, width, height=900, ratio=1, dark=False):
        self.ask("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=ratio,
                 mobile=width < 600)
        scheme = "dark" if dark else "light"
        self.ask("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
        self.ask("Page.navigate", url="file://" + os.path.abspath(path))
        for _ in range(600):
            if self.value("document.readyState === 'complete' && location.protocol === 'file:' && !!window.undula"):
                break
            time.sleep(0.05)
        self.value("undula.ready")
        self.settle()

    def settle(self):
        """Waits until what was asked for is drawn."""
        self.value("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => "
                   "setTimeout(done, 30))))")

    def key(self, key):
        code = {" ": 32, "ArrowLeft": 37, "ArrowRight": 39, "Home": 36, "End": 35}.get(key, 0)
        text = {"text": key} if len(key) == 1 else {}
        self.ask("Input.dispatchKeyEvent", type="keyDown", key=key, windowsVirtualKeyCode=code, **text)
        self.ask("Input.dispatchKeyEvent", type="keyUp", key=key, windowsVirtualKeyCode=code)

    def mouse(self, kind, x, y, button="none"):
        self.ask("Input.dispatchMouseEvent", type=kind, x=x, y=y, button=button, clickCount=1)

    def picture(self, path, whole=True):
        size = self.ask("Page.getLayoutMetrics")["cssContentSize"]
        clip = {"x": 0, "y": 0, "width": size["width"], "height": size["height"] if whole else 900, "scale": 1}
        shot = self.ask("Page.captureScreenshot", captureBeyondViewport=True, clip=clip)
        with open(path, "wb") as file:
            file.write(base64.b64decode(shot["data"]))

    def wrong(self):
        """Errors of the console, and requests for anything but files."""
        found = []
        for event in self.events:
            method, params = event.get("method"), event.get("params", {})
            if method == "Runtime.exceptionThrown":
                details = params["exceptionDetails"]
                found.append(details.get("exception", {}).get("description", details["text"]))
            elif method == "Runtime.consoleAPICalled" and params["type"] in ["error", "assert"]:
                found.append(str(params["args"]))
            elif method == "Log.entryAdded" and params["entry"]["level"] == "error":
                found.append(params["entry"]["text"])
            elif method == "Network.requestWillBeSent":
                url = params["request"]["url"]
                if not url.startswith(("file:", "about:", "data:", "blob:")):
                    found.append(f"asked for {url}")
        return found

    def close(self):
        self.process.terminate()
        self.process.wait()
        shutil.rmtree(self.profile, ignore_errors=True)


def read_vtu(path):
    """Arrays of a file of Undula by name: tuples of numbers."""
    with open(path, "rb") as file:
        head, _, data = file.read().partition(b'<AppendedData encoding="raw">')
    data = data[data.index(b"_") + 1:]
    kinds = {"Float64": "d", "Float32": "f", "Int64": "q", "UInt8": "B"}
    found = {}
    entry = (r'<DataArray type="(\w+)" Name="([\w-]+)"(?: NumberOfComponents="(\d+)")? format="appended" '
             r'offset="(\d+)"')
    for kind, name, components, offset in re.findall(entry, head.decode("latin-1")):
        at, width = int(offset), int(components or 1)
        blocks = struct.unpack_from("<Q", data, at)[0]
        sizes = struct.unpack_from(f"<{blocks}Q", data, at + 24)
        at += 24 + 8 * blocks
        raw = b""
        for size in sizes:
            raw += zlib.decompress(data[at:at + size])
            at += size
        values = array(kinds[kind], raw)
        found[name] = [tuple(values[i:i + width]) for i in range(0, len(values), width)]
    return found


class Fields:
    """The fields of one moment."""

    def __init__(self, path):
        self.arrays = read_vtu(path)
        nodes = [n for (n,) in self.arrays["connectivity"]]
        ends = [n for (n,) in self.arrays["offsets"]]
        self.cells = [nodes[a:b] for a, b in zip([0, *ends], ends)]
        assert all(len(cell) in (3, 4) for cell in self.cells), "cells have to be straight"

    def at(self, name, x, y):
        """The tuple of a field at a place, bilinear in quadrilaterals, and whether the cell there is solid."""
        points = self.arrays["Points"]
        for number, cell in enumerate(self.cells):
            corners = [points[p] for p in cell]
            if not (min(c[0] for c in corners) <= x <= max(c[0] for c in corners)
                    and min(c[1] for c in corners) <= y <= max(c[1] for c in corners)):
                continue
            weights = weights_of(corners, x, y)
            if weights and min(weights) > -1e-9:
                values = [self.arrays[name][p] for p in cell]
                solid = self.arrays["solid"][number][0] > 0.5
                return [sum(w * v[c] for w, v in zip(weights, values)) for c in range(len(values[0]))], solid
        return None, None


def weights_of(corners, x, y):
    """Weights of the corners at a place; None if Newton's method does not find them."""
    r = s = 1 / 3
    for _ in range(30):
        if len(corners) == 3:
            weights, by_r, by_s = [1 - r - s, r, s], [-1, 1, 0], [-1, 0, 1]
        else:
            weights = [(1 - r) * (1 - s), r * (1 - s), r * s, (1 - r) * s]
            by_r, by_s = [s - 1, 1 - s, s, -s], [r - 1, -r, r, 1 - r]
        sums = [[sum(w * c[d] for w, c in zip(of, corners)) for d in (0, 1)] for of in (weights, by_r, by_s)]
        (px, py), (ax, ay), (bx, by) = sums
        area = ax * by - bx * ay
        if area == 0:
            return None
        dr, ds = ((x - px) * by - bx * (y - py)) / area, (ax * (y - py) - (x - px) * ay) / area
        r, s = r + dr, s + ds
        if abs(dr) + abs(ds) < 1e-12:
            return weights
    return None


def numbers(text):
    """Numbers of a text with the minus sign of people."""
    return [float(n) for n in re.findall(r"-?\d[\d.]*(?:e-?\d+)?", text.replace("\u2212", "-"))]


def compare(browser, directory, report):
    """What the player tells under the pointer beside the field files."""
    pvd = open(os.path.join(directory, "fields.pvd"), encoding="utf-8").read()
    files = {float(t): file for t, file in re.findall(r'timestep="([^"]+)"[^>]*file="([^"]+)"', pvd)}
    times = browser.value("undula.player.scene.times")
    choices = browser.value("undula.player.choices")
    checked = 0
    for frame in sorted({0, len(times) // 2, len(times) - 1}):
        fields = Fields(os.path.join(directory, files[times[frame]]))
        points = fields.arrays["Points"]
        places = [points[n] for n in range(7, len(points), max(1, len(points) // 12))]
        for number, choice in enumerate(choices):
            browser.value(f"undula.player.setFrame({frame}); undula.player.setChoice({number})")
            browser.settle()
            name = browser.value(f"undula.player.scene.quantities[{choice['quantity']}].name")
            parts = fields.arrays[name]
            # Of a tensor in rows xx, xy, yy, zz are shown.
            places_of = [0, 1, 4, 8] if len(parts[0]) == 9 else range(len(parts[0]))
            size = lambda v: math.hypot(*v) if choice["component"] is None else v[places_of[choice["component"]]]
            largest = max((abs(size(v)) for v in parts if all(map(math.isfinite, v))), default=0)
            for place in places:
                told = tell(browser, place[0] + 1e-3, place[1] + 1e-3)
                if not told or "\u2013" in told:
                    continue
                x, y, value = numbers(told.replace(choice["symbol"], ""))[:3]
                at, _ = fields.at(name, x, y)
                if at is None or not all(map(math.isfinite, at)):
                    continue
                right = choice["factor"] * size(at)
                allowed = 0.01 * abs(right) + 1e-3 * choice["factor"] * largest
                checked += 1
                if abs(value - right) > allowed:
                    report(f"t = {times[frame]}, {choice['label']} at ({x}, {y}): {value}, the file has {right}")
    if checked < 20:
        report(f"only {checked} values were compared")
    return checked


def tell(browser, x, y):
    """What stands below the picture while the pointer is at a place \\[m\\]."""
    to = browser.value(
        f"(() => {{ const p = undula.player, to = {{x: [0], y: [0]}}; p.view.project([[{x}], [{y}]], to, "
        "p.canvas.width, p.canvas.height); const box = p.canvas.getBoundingClientRect(); "
        "return [box.left + to.x[0] / p.ratio, box.top + to.y[0] / p.ratio]; })()")
    browser.mouse("mouseMoved", *to)
    browser.settle()
    return browser.value("undula.player.readout.textContent").strip()


def play(browser, report):
    """Keys and buttons, and how fast the picture is drawn."""
    frames = browser.value("undula.player.scene.times.length")
    frame = lambda: browser.value("undula.player.frame")
    browser.value("undula.player.canvas.scrollIntoView({block: 'center'}); undula.player.canvas.focus()")
    if frames > 1:
        browser.key("Home")
        if frame() != 0:
            report("Home does not lead to the first moment")
        browser.key("ArrowRight")
        if frame() != 1:
            report("the right arrow does not lead to the next moment")
        browser.settle()
        before = browser.value("undula.player.canvas.toDataURL()")
        browser.key(" ")
        start, moved = frame(), False
        for _ in range(100):
            time.sleep(0.02)
            moved = moved or frame() != start
        if not moved or not browser.value("undula.player.playing"):
            report("the player does not play")
        browser.key(" ")
        if browser.value("undula.player.playing"):
            report("the player does not stop")
        browser.key("End")
        browser.settle()
        if frames > 2 and browser.value("undula.player.canvas.toDataURL()") == before:
            report("the picture stays the same")
    label = browser.value("undula.player.legend.textContent")
    browser.key("q")
    browser.settle()
    several = browser.value("undula.player.choices.length") > 1
    if several and browser.value("undula.player.legend.textContent") == label:
        report("q does not lead to another quantity")
    browser.value("undula.player.setChoice(0)")
    browser.key("m")
    browser.settle()
    spent = browser.value(
        "(() => { const p = undula.player, n = 60, t = performance.now(); for (let i = 0; i < n; i++) "
        "{ p.frame = i % p.scene.times.length; p.draw(); } return (performance.now() - t) / n; })()")
    browser.key("m")
    return 1000 / spent


def gestures(browser, report):
    """Charts are zoomed by dragging; two fingers enlarge the fields on a phone."""
    if browser.value("!!undula.histories"):
        box = browser.value(
            "(() => { const c = undula.histories[0].chart.canvas; c.scrollIntoView({block: 'center'}); "
            "const b = c.getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; })()")
        y = box[1] + box[3] / 2
        ends = [box[0] + 62 + part * (box[2] - 72) for part in (0.25, 0.5)]
        browser.mouse("mousePressed", ends[0], y, "left")
        browser.mouse("mouseMoved", ends[1], y, "left")
        browser.mouse("mouseReleased", ends[1], y, "left")
        first, last, low, high = browser.value(
            "(() => { const c = undula.histories[0].chart, r = c.group.range ?? [NaN, NaN]; "
            "return [c.x[0], c.x[c.x.length - 1], ...r]; })()")
        right = [first + part * (last - first) for part in (0.25, 0.5)]
        if low is None or abs(low - right[0]) + abs(high - right[1]) > 0.02 * (last - first):
            report(f"dragging shows {low} to {high}, expected {right}")
        told = browser.value("undula.histories[0].chart.readout.textContent")
        if "t =" not in told:
            report(f"no value is told under the pointer: {told}")
        browser.value("undula.histories[0].chart.group.zoom(null)")
    if browser.value("!!undula.player"):
        x, y = browser.value(
            "(() => { const c = undula.player.canvas; c.scrollIntoView({block: 'center'}); "
            "const b = c.getBoundingClientRect(); return [b.left + b.width / 2, b.top + b.height / 2]; })()")
        browser.ask("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=2)
        before = browser.value("undula.player.view.scale")
        fingers = lambda d: [{"x": x - d, "y": y, "id": 0}, {"x": x + d, "y": y, "id": 1}]
        browser.ask("Input.dispatchTouchEvent", type="touchStart", touchPoints=fingers(20))
        for d in (30, 45, 60):
            browser.ask("Input.dispatchTouchEvent", type="touchMove", touchPoints=fingers(d))
        browser.ask("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
        browser.settle()
        factor = browser.value("undula.player.view.scale") / before
        browser.ask("Emulation.setTouchEmulationEnabled", enabled=False)
        if not 2 < factor < 4:
            report(f"two fingers enlarge by {factor}, expected 3")
        browser.value("undula.player.fit()")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("directory", help="directory of a run with report.html")
    parser.add_argument("--pictures", metavar="DIR", help="directory for pictures of the page")
    parser.add_argument("--rate", type=float, default=0, help="moments a second that have to be drawn")
    arguments = parser.parse_args()
    program = next(filter(None, map(shutil.which, BROWSERS)), None)
    if not program:
        sys.exit("no browser: " + ", ".join(BROWSERS))
    found = []
    report = lambda text: (found.append(text), print("wrong:", text))
    page = os.path.join(arguments.directory, "report.html")
    print(f"{page}: {os.path.getsize(page) / 1e6:.2f} MB")
    browser = Browser(program)
    try:
        browser.open(page, 1600)
        empty = browser.value("pictures.filter(p => p.x && !(p.width > 0)).length")
        if empty:
            report(f"{empty} charts are not drawn")
        if browser.value("!!undula.player"):
            rate = play(browser, report)
            moments = browser.value("undula.player.scene.times.length")
            print(f"{rate:.0f} moments a second at 1600 pixels, {moments} moments")
            if rate < arguments.rate:
                report(f"{rate:.1f} moments a second, expected {arguments.rate}")
            if browser.value("undula.player.scene.dimension") == 2:
                print(f"{compare(browser, arguments.directory, report)} values compared")
        for width, dark in [(400, False), (400, True), (1600, False), (1600, True)]:
            browser.open(page, width, ratio=2 if width < 600 else 1, dark=dark)
            gestures(browser, report)
            if browser.value("document.documentElement.scrollWidth") > width:
                report(f"the page is wider than {width} pixels")
            if arguments.pictures:
                os.makedirs(arguments.pictures, exist_ok=True)
                browser.picture(os.path.join(arguments.pictures, f"{width}-{'dark' if dark else 'light'}.png"))
        for text in browser.wrong():
            report(text)
    finally:
        browser.close()
    print("nothing wrong" if not found else f"{len(found)} wrong")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
