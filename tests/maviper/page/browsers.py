"""Runs a page's scripts, with more at their end, in Node.js or in Chromium.

Does: gives back what the last script returns, as JSON would.
Assumes: a page as `maviper.page.page` renders it.
Does not: judge what comes back.
"""

import functools
import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.support.chromium import COMMAND, SECONDS, Chromium

SCRIPTS = re.compile(r"<script>\n(.*?)</script>", re.DOTALL)
DATA = re.compile(r'<script type="application/json" id="data">(.*?)</script>', re.DOTALL)


def in_node(page, script, given, folder):
    """What `script` returns, with `data`, `Policy`, `Engine`, `game`, `judges` and `given` at hand."""
    if shutil.which("node") is None:
        pytest.skip("node is not installed")
    module, engine, _ = SCRIPTS.findall(page)
    (data,) = DATA.findall(page)
    lines = [
        f"const data = {data};",
        module,
        engine,
        "const game = Engine.prepared(data);",
        "const judges = data.claims.map((claim) => Engine.judge(game, claim));",
        f"const given = {json.dumps(given)};",
        f"console.log(JSON.stringify((() => {{ {script} }})()));",
    ]
    file = folder / "run.js"
    file.write_text("\n".join(lines), encoding="utf-8")
    done = subprocess.run(["node", file], capture_output=True, text=True, check=False, timeout=SECONDS)
    assert done.returncode == 0, done.stderr[-2000:]
    return json.loads(done.stdout)


def in_chromium(page, script, given, folder, width=1200):
    """As `in_node`, in the page itself as Chromium opens it from a file; also the page's own errors are errors."""
    if COMMAND is None:
        pytest.skip("chromium is not installed")
    told = f"""
    <pre id="told"></pre><script>
    (() => {{
      const told = document.getElementById("told");
      try {{
        const data = JSON.parse(document.getElementById("data").textContent);
        const {{ game, judges }} = window.maviper;
        const given = {json.dumps(given).replace("<", chr(92) + "u003c")};
        told.textContent = JSON.stringify((() => {{ {script} }})()) ?? "null";
      }} catch (error) {{
        told.textContent = "error " + error.stack;
      }}
      if (window.failed) told.textContent = "error " + window.failed;
    }})();
    </script>"""
    watch = '<script type="text/javascript">window.onerror = (what) => { window.failed = what; };</script>'
    file = folder / "run.html"
    file.write_text(page.replace("<body>", f"<body>{watch}").replace("</body>", told + "</body>"), encoding="utf-8")
    (text,) = _framed([file], width, "inside.getElementById('told').textContent", folder)
    assert not text.startswith("error"), text
    return json.loads(text)


def overhang(files, folder, width):
    """By how many pixels each page is wider than a screen of this width, in Chromium; pages as files."""
    if COMMAND is None:
        pytest.skip("chromium is not installed")
    wider = "inside.documentElement.scrollWidth - inside.documentElement.clientWidth"
    return [int(text) for text in _framed(files, width, wider, folder)]


def violations(file, folder):
    """The rules of axe-core that a page breaks; the variable AXE_CORE names its axe.min.js."""
    axe = os.environ.get("AXE_CORE")
    if COMMAND is None or not axe:
        pytest.skip("chromium or axe-core is not installed: AXE_CORE names its axe.min.js")
    page = folder / "axe.html"
    scripts = f"<script>{Path(axe).read_text(encoding='utf-8')}</script></body>"
    page.write_text(file.read_text(encoding="utf-8").replace("</body>", scripts), encoding="utf-8")
    return _browser().evaluated(page.as_uri(), "axe.run().then((all) => all.violations.map((one) => one.id))")


def _framed(files, width, expression, folder):
    """What an expression is in each page, as text. Pages stand in frames, as a window is never narrower than 500."""
    frames = "".join(
        f'<iframe src="{file.as_uri()}" style="width:{width}px; height:900px; border:0" onload="read(this)"></iframe>'
        for file in files
    )
    script = f"""const found = [];
    function read(frame) {{
      const inside = frame.contentDocument;
      found[[...document.querySelectorAll("iframe")].indexOf(frame)] = String({expression});
    }}"""
    outer = folder / "frames.html"
    outer.write_text(f"<!DOCTYPE html><meta charset=utf-8><script>{script}</script><body>{frames}</body>", "utf-8")
    found = _browser().evaluated(outer.as_uri(), "found")
    assert len(found) == len(files) and None not in found
    return found


@functools.cache
def _browser():
    return Chromium()


RUNNERS = {"node": in_node, "chromium": in_chromium}
