"""The page as one file: what `palpate.html` loads is inside it, so that it opens from a folder without a server.

    page.py FOLDER        # reads FOLDER/index.html and what it loads, writes FOLDER/palpate.html
"""

import base64
import json
import pathlib
import sys

folder = pathlib.Path(sys.argv[1])


def inside(name: str) -> str:
    return base64.b64encode((folder / name).read_bytes()).decode()


modules = {f"palpate/{path.name}": f"data:text/javascript;base64,{inside(path.name)}" for path in sorted(folder.glob("*.js"))}
replaced = {
    '<link rel="stylesheet" href="style.css">': f"<style>{(folder / 'style.css').read_text()}</style>",
    '{ "imports": { "palpate/": "./" } }': json.dumps({"imports": modules}),
    "<script>\n// What a browser": f'<script type="text/plain" id="module">{inside("palpate.wasm")}</script>\n<script>\n// What a browser',
    "script-src 'self'": "script-src data:",
}
page = (folder / "index.html").read_text()
for what, instead in replaced.items():
    if what not in page:
        sys.exit(f"page.py: expected {what!r} in index.html")
    page = page.replace(what, instead)
(folder / "palpate.html").write_text(page)
