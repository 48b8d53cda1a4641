"""Follow a fleet: who is there, who is lost, low on battery or off its track. `python follow.py ORG`, where this machine has a place in it."""

import sys
import time

import vencejo
from vencejo.fleet import Fleet

with vencejo.Station(record=False, heartbeat=False) as station, Fleet(station, org=sys.argv[1], history=False) as fleet:
    while True:
        planes = {plane.remote_name: plane for plane in station.vehicles}
        for far in fleet.aircraft:
            now = planes[far.name].telemetry if far.name in planes else None
            at = now.position if now else None
            battery = now.batteries[0].remaining_pct if now and now.batteries else None
            off_m = now.nav.cross_track_error_m if now and now.nav else None
            alarms = ["LOST"] if far.age_s > 5 else []
            alarms += ["BATTERY LOW"] if battery is not None and battery < 25 else []
            alarms += ["OFF ITS TRACK"] if off_m is not None and abs(off_m) > 100 else []
            where = f"{at.lat_deg:.5f} {at.lon_deg:.5f}" if at and at.lat_deg is not None else "position unknown"
            mode = now.mode if now else None
            print(f"{far.name}: {mode or 'mode unknown'}, {where}, control: {far.holder or 'nobody'}", *alarms)
        time.sleep(1)
