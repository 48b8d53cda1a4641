"""Our parser finds every frame that MAVLink's C library finds in a damaged stream.

The library is generated from pymavlink's own definitions and compiled for the test; how many frames it is given can be said from
outside (VENCEJO_TEST_FRAMES).
"""

from __future__ import annotations

import os
import random
import shutil
import subprocess
from pathlib import Path

import pymavlink
import pytest
from pymavlink.generator import mavgen

from tests.support import CAPTURES, ROOT

FRAMES = int(os.environ.get("VENCEJO_TEST_FRAMES", "100000"))
KEY = 8
STX = b"\xfd"
OURS = ROOT / "target/debug/examples/known_frames"
PROGRAM = r"""
#include <stdio.h>
#include <mavlink.h>
int main(void) {
    static unsigned char piece[1 << 16];
    mavlink_message_t message;
    mavlink_status_t status;
    size_t count;
    while ((count = fread(piece, 1, sizeof piece, stdin)) > 0)
        for (size_t at = 0; at < count; at++)
            if (mavlink_parse_char(MAVLINK_COMM_0, piece[at], &message, &status) == MAVLINK_FRAMING_OK
                && mavlink_get_msg_entry(message.msgid)) {
                unsigned char key[8] = {message.msgid, message.msgid >> 8, message.msgid >> 16, message.seq,
                    message.sysid, message.compid, message.ck[0], message.ck[1]};
                fwrite(key, 1, sizeof key, stdout);
            }
    return 0;
}
"""


def c_parser(folder: Path) -> Path:
    """Generate and compile the library with a program that prints the frames it finds."""
    definitions = Path(pymavlink.__file__).parent / "dialects/v20/ardupilotmega.xml"
    options = mavgen.Opts(str(folder / "c"), wire_protocol="2.0", language="C", validate=False)
    assert mavgen.mavgen(options, [str(definitions)])
    source, program = folder / "parser.c", folder / "parser"
    source.write_text(PROGRAM)
    headers = folder / "c/ardupilotmega"
    command = ["cc", "-O1", "-w", f"-I{headers}", "-o", str(program), str(source)]
    subprocess.run(command, check=True, capture_output=True)
    return program


def frames_of(stream: bytes) -> list[bytes]:
    """Return the frames of an undamaged recording."""
    found, at = [], 0
    while at < len(stream):
        assert stream[at] == 0xFD
        end = at + 12 + stream[at + 1] + (13 if stream[at + 2] & 1 else 0)
        found.append(stream[at:end])
        at = end
    return found


def key(frame: bytes) -> bytes:
    """Return the bytes by which both programs identify a frame."""
    end = len(frame) - (13 if frame[2] & 1 else 0)
    return frame[7:10] + frame[4:7] + frame[end - 2 : end]


@pytest.mark.peer
@pytest.mark.skipif(shutil.which("cc") is None, reason="compiles the C library")
@pytest.mark.fault(
    54,
    figure="100,000 frames with damaged and missing bytes and noise between: 0 that the C library finds are missed",
    seeds=1,
)
def test_what_the_c_library_finds_is_found(tmp_path: Path) -> None:
    recorded = frames_of((CAPTURES / "arduplane-50hz-20s.mavlink").read_bytes())
    chance = random.Random(54)
    path, sent = tmp_path / "stream", []
    with path.open("wb") as stream:
        for number in range(FRAMES):
            frame = recorded[number % len(recorded)]
            sent.append(key(frame))
            kind = chance.random()
            if kind < 0.05:  # a changed byte
                at = chance.randrange(len(frame))
                frame = frame[:at] + bytes([chance.randrange(256)]) + frame[at + 1 :]
            elif kind < 0.08:  # truncated
                rest = chance.randrange(len(frame))
                # A start byte of the next frame would end this one: both would share it, and no parser can find both.
                frame = frame if frame[rest:] == STX else frame[:rest]
            elif kind < 0.1:  # preceded by noise
                frame = chance.randbytes(chance.randrange(1, 40)) + frame
            stream.write(frame)
        stream.write(bytes(300))
    # As built by `make test`: with other features, its dependencies would be recompiled.
    options = ("--workspace", "--features", "vencejo-py/fleet", "--example", "known_frames", "--quiet", "--locked")
    subprocess.run(["cargo", "build", *options], cwd=ROOT, check=True)
    with path.open("rb") as stream:
        theirs = subprocess.run([c_parser(tmp_path)], stdin=stream, capture_output=True, check=True).stdout
    with path.open("rb") as stream:
        ours = subprocess.run([OURS], stdin=stream, capture_output=True, check=True).stdout
    true = set(sent)
    ours_found = [ours[at : at + KEY] for at in range(0, len(ours), KEY)]
    theirs_found = [found for at in range(0, len(theirs), KEY) if (found := theirs[at : at + KEY]) in true]
    assert len(theirs_found) > 0.8 * FRAMES, "it found most of them"
    # The library's frames appear in the same order among ours.
    mine = iter(ours_found)
    assert all(found in mine for found in theirs_found), "a frame that the C library finds and we do not"
    assert len(ours_found) >= len(theirs_found)
