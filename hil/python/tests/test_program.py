"""The program `hil` as the wheel's console script."""

from __future__ import annotations

import shutil
import signal
import socket
import subprocess
import sys
import sysconfig
import time
from pathlib import Path

import pytest

from hil import hil
from palpate import _program


def script() -> str:
    """The script beside this interpreter."""
    found = shutil.which("hil", path=sysconfig.get_path("scripts"))
    if found is None:
        pytest.skip("the wheel is not installed, so there is no script")
    return found


def done(*arguments: object, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    words = [script(), *map(str, arguments)]
    return subprocess.run(words, capture_output=True, text=True, cwd=cwd)


def test_it_prints_what_the_program_prints(tmp_path: Path) -> None:
    for words in (["list", "scenes"], ["list", "benches"], ["--version"], ["run", "--help"]):
        assert done(*words).stdout == hil(*words)
    for name, program in (("own.jsonl", done), ("theirs.jsonl", hil)):
        program("run", "sphere-along", "--seed", 3, "--schedule", tmp_path / name)
    assert (tmp_path / "own.jsonl").read_bytes() == (tmp_path / "theirs.jsonl").read_bytes()


@pytest.mark.parametrize(
    ("words", "status"),
    [(["run", "none-such"], 2), (["run", "--none-such"], 2), (["frobnicate"], 2), (["--help"], 0)],
)
def test_its_status_is_the_programs(words: list[str], status: int) -> None:
    assert done(*words).returncode == status


def test_ctrl_c_ends_it(tmp_path: Path) -> None:
    words = [script(), "sweep", "sphere-along", "--seeds", "1..20000", "--out", str(tmp_path / "runs.jsonl"), "--quiet"]
    program = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
    while not (tmp_path / "runs.jsonl").exists():
        time.sleep(0.02)
        assert program.poll() is None
    program.send_signal(signal.SIGINT)
    _, said = program.communicate(timeout=30)
    assert program.returncode == 130
    assert "Traceback" not in said


def test_its_guardian_is_a_process_of_its_own(tmp_path: Path) -> None:
    # As a run on hardware starts it: a socket as its standard input, over which it says why it cannot guard.
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    # A folder whose files must not be taken for modules.
    (tmp_path / "numpy.py").write_text("raise SystemExit('not this one')")
    guard = [sys.executable, _program.__file__, "guardian", f"--i2c={tmp_path}/none=40", "--heartbeat-ms=100", "--transfer-ms=5"]
    with subprocess.Popen(guard, stdin=theirs.fileno(), cwd=tmp_path, stderr=subprocess.PIPE) as process:
        theirs.close()
        ours.settimeout(20)
        answer = ours.recv(65536)
        assert str(tmp_path / "none") in answer.decode(errors="replace"), answer
        assert process.wait(20) != 0
        assert process.stderr is not None and process.stderr.read() == b""
