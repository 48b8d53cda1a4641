#!/usr/bin/env python3
"""Design a landing at home, into the wind, and save a short mission that ends with it. Nothing is sent to the plane.

Usage: python design_landing.py FILE WIND_FROM_DEG WIND_SPEED_M_S [LINK]
"""

import sys

import vencejo
from vencejo import Home, MissionItem, Plan
from vencejo.geodesy import destination
from vencejo.landing import Wind, design_landing

if len(sys.argv) < 4:
    sys.exit(__doc__)
file, wind_from_deg, wind_speed_m_s = sys.argv[1], float(sys.argv[2]), float(sys.argv[3])
link = sys.argv[4] if len(sys.argv) > 4 else "tcp:127.0.0.1:5760"

with vencejo.connect(link, record=False) as plane:
    home = plane.wait_until(lambda now: now.home, timeout_s=60, what="having a home").home
assert home is not None
field = home.point

# ground_rel_home_m=0: we land where we start. A steeper slope or another circle are arguments as well.
landing = design_landing(field, wind=Wind(wind_from_deg, wind_speed_m_s), ground_rel_home_m=0.0, has_land_start=False)
print(f"final leg {landing.final_m:.0f} m, course {landing.course_deg:.0f}°, headwind {landing.headwind_m_s} m/s")
for caution in landing.cautions:
    print(f"caution: {caution.message}")

climb_out = destination(field, bearing_deg=wind_from_deg, distance_m=300)
upwind = destination(field, bearing_deg=wind_from_deg, distance_m=500)
plan = Plan(
    home=Home(home.lat_deg, home.lon_deg, home.alt_amsl_m),
    items=(
        MissionItem.takeoff(climb_out.lat_deg, climb_out.lon_deg, alt_rel_home_m=40.0),
        MissionItem.waypoint(upwind.lat_deg, upwind.lon_deg, alt_rel_home_m=60.0),
        *landing.items,
    ),
)
for finding in plan.check(position=home):
    print(finding)
plan.save(file)
print(f"{len(plan)} items saved to {file}; fly them with fly_plan.py")
