#!/usr/bin/env python3
"""Follow a vehicle and write a row a second to a CSV file, until Ctrl-C. It only listens and asks for telemetry.

Usage: python follow_to_csv.py [FILE] [LINK]
"""

import contextlib
import csv
import sys
from pathlib import Path

import vencejo

file = Path(sys.argv[1] if len(sys.argv) > 1 else "flight.csv")
link = sys.argv[2] if len(sys.argv) > 2 else "tcp:127.0.0.1:5760"

COLUMNS = ("time_s", "mode", "lat_deg", "lon_deg", "alt_rel_home_m", "airspeed_m_s", "groundspeed_m_s", "battery_pct")

with vencejo.connect(link) as plane, file.open("w", newline="", encoding="utf-8") as output:
    rows = csv.writer(output)
    rows.writerow(COLUMNS)
    with contextlib.suppress(KeyboardInterrupt):
        for now in plane.stream(rate_hz=1):
            # A group is None until the vehicle has sent it; a value is None when the vehicle does not know it: an empty cell.
            position, hud, power = now.position, now.hud, now.sys_status
            rows.writerow(
                (
                    f"{now.time_s:.2f}",
                    now.mode,
                    *((position.lat_deg, position.lon_deg, position.alt_rel_home_m) if position else (None,) * 3),
                    *((hud.airspeed_m_s, hud.groundspeed_m_s) if hud else (None,) * 2),
                    power.battery_remaining_pct if power else None,
                )
            )
            output.flush()
print(f"written to {file}")
