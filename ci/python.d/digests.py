"""Prints a digest of all tables of two runs: the same on every version of Python."""

import hashlib

import palpate

digest = hashlib.sha256()
for run in (palpate.run("sphere-along"), palpate.run("allegro-grasp", bench="allegro-hand")):
    digest.update(repr(run.digests).encode())
    for name in ("contacts", "stimuli", "felt", "temperatures", "warmth", "margins", "taxels", "edges"):
        digest.update(getattr(run, name).tobytes())
print(digest.hexdigest()[:16])
