"""A panic of the core is an exception in Python, and Python goes on: no end of the process.

There is no function that panics on purpose. But the runtime cannot begin where the system gives it no threads, and the core
has no better answer to that than a panic: a process of its own is let have no memory for their stacks.
"""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.support import ROOT

PROGRAM = """
import resource, vencejo

def held():
    for line in open("/proc/self/status"):
        if line.startswith("VmSize:"):
            return int(line.split()[1]) * 1024

usual = resource.getrlimit(resource.RLIMIT_AS)
# Room for what Python does, none for the stack of a thread.
resource.setrlimit(resource.RLIMIT_AS, (held() + (1 << 20), usual[1]))
try:
    vencejo.Station("udpin:127.0.0.1:0", record=False)
except BaseException as error:
    told = error
resource.setrlimit(resource.RLIMIT_AS, usual)
print(type(told).__module__, type(told).__name__, isinstance(told, Exception))
with vencejo.Station("udpin:127.0.0.1:0", record=False) as station:
    print(len(station.links), "link")
"""


@pytest.mark.skipif(sys.platform != "linux", reason="takes a thread's stack away as Linux does")
@pytest.mark.fault(55, figure="a panic in the core is a PanicException in Python; the next call works")
def test_a_panic_is_an_exception_and_python_goes_on() -> None:
    ended = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, timeout=60, check=False)
    assert ended.returncode == 0, ended
    assert ended.stdout.splitlines() == ["pyo3_runtime PanicException False", "1 link"], ended
    assert "panicked at" in ended.stderr


def test_no_build_turns_a_panic_into_an_abort() -> None:
    """PyO3 catches unwinding panics at every function and method; an abort could not be caught."""
    manifest = (ROOT / "Cargo.toml").read_text(encoding="utf-8")
    assert 'panic = "unwind"' in manifest.partition("[profile.release]")[2]
    assert 'panic = "abort"' not in manifest
