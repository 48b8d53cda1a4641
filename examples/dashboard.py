#!/usr/bin/env python3
"""All telemetry of a vehicle in the terminal, until Ctrl-C. Usage: python dashboard.py [LINK]."""

import contextlib
import sys

import vencejo
from rich.live import Live
from rich.table import Table

link = sys.argv[1] if len(sys.argv) > 1 else "tcp:127.0.0.1:5760"
with contextlib.suppress(KeyboardInterrupt), vencejo.connect(link) as plane, Live() as screen:
    for now in plane.stream(rate_hz=4):
        table = Table("group", "age, s", "values", title=f"vehicle {plane.system_id} · {now.mode}")
        for name, group in now.groups():
            values = {key: value for key, value in vars(group).items() if key not in ("age_s", "has_invalid")}
            table.add_row(name, f"{group.age_s:.1f}", str(values), style=None if group.freshness == "fresh" else "dim")
        screen.update(table)
