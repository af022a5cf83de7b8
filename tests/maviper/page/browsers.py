"""Runs a page's scripts, with more at their end, in Node.js or in Chromium.

Does: gives back what the last script returns, as JSON would.
Assumes: a page as `maviper.page.page` renders it.
Does not: judge what comes back.
"""

import json
import re
import shutil
import subprocess

import pytest

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
SCRIPTS = re.compile(r"<script>\n(.*?)</script>", re.DOTALL)
DATA = re.compile(r'<script type="application/json" id="data">(.*?)</script>', re.DOTALL)
QUIETLY = ("--headless", "--no-sandbox", "--disable-gpu")
SECONDS = 300


def in_node(html, script, given, folder):
    """What `script` returns, with `data`, `Policy`, `Engine`, `game`, `judges` and `given` at hand."""
    if shutil.which("node") is None:
        pytest.skip("node is not installed")
    module, engine, _ = SCRIPTS.findall(html)
    (data,) = DATA.findall(html)
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


def in_chromium(html, script, given, folder, width=1200):
    """As `in_node`, in the page itself as Chromium opens it from a file; also the page's own errors are errors."""
    if CHROMIUM is None:
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
    file.write_text(html.replace("<body>", f"<body>{watch}").replace("</body>", told + "</body>"), encoding="utf-8")
    command = [
        CHROMIUM,
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        f"--user-data-dir={folder / 'user'}",
        "--dump-dom",
    ]
    done = subprocess.run([*command, file.as_uri()], capture_output=True, text=True, check=False, timeout=SECONDS)
    found = re.search(r'<pre id="told">(.*?)</pre>', done.stdout, re.DOTALL)
    assert found is not None, done.stderr[-2000:]
    text = found[1].replace("&amp;", "&").replace("&lt;", "<").replace("&gt;", ">")
    assert not text.startswith("error"), text
    return json.loads(text)


RUNNERS = {"node": in_node, "chromium": in_chromium}
