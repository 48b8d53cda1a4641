"""Still pictures that know where they were taken.

EXIF 2.32 (CIPA DC-008) and XMP are put into the JPEG file beside its picture, which is not encoded anew. EXIF holds
time, position, height above sea level and the direction of view; XMP holds the attitude, in the ``Camera`` terms
(Pix4D's, version 1.0) that mapping programs read, and the height above home.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from datetime import datetime, timedelta, timezone
from typing import TYPE_CHECKING, Final
from xml.sax.saxutils import quoteattr

from vencejo.camera import jpeg
from vencejo.camera.errors import CameraError

if TYPE_CHECKING:
    from vencejo.telemetry import Telemetry

__all__ = ["Pose", "pose_of", "with_pose"]

MAX_AGE_S: Final = 3.5
"""An older position or attitude is not where the picture was taken (the age at which values count as stale)."""
EARTH_RADIUS_M: Final = 6_371_008.8
"""Mean radius (IUGG)."""

# Numbers of EXIF tags, CIPA DC-008 tables 4 to 15.
SOFTWARE: Final = 0x0131
DATE_TIME: Final = 0x0132
EXIF_FOLDER: Final = 0x8769
GPS_FOLDER: Final = 0x8825
DATE_TIME_ORIGINAL: Final = 0x9003
OFFSET_TIME_ORIGINAL: Final = 0x9011
SUBSEC_TIME_ORIGINAL: Final = 0x9291
XMP_HEADER: Final = b"http://ns.adobe.com/xap/1.0/\0"


@dataclass(frozen=True, kw_only=True)
class Pose:
    """Position and orientation of a camera; ``None`` for unknown values.

    Attributes
    ----------
    lat_deg, lon_deg : float or None
        WGS 84.
    alt_amsl_m, alt_rel_home_m : float or None
    roll_deg, pitch_deg, yaw_deg : float or None
        Attitude of the vehicle: right wing down, nose up, nose clockwise from true north.
    """

    lat_deg: float | None = None
    lon_deg: float | None = None
    alt_amsl_m: float | None = None
    alt_rel_home_m: float | None = None
    roll_deg: float | None = None
    pitch_deg: float | None = None
    yaw_deg: float | None = None


def pose_of(telemetry: Telemetry, age_s: float) -> Pose:
    """Where a vehicle was when a picture was taken.

    Parameters
    ----------
    telemetry : Telemetry
        What is known of the vehicle now.
    age_s : float
        How long ago the picture was taken. The position is taken back, or on, by the velocity for the time between the
        two.

    Returns
    -------
    Pose
        Without what is older than 3.5 s.
    """
    position, attitude = telemetry.position, telemetry.attitude
    values: dict[str, float | None] = {}
    if (
        position is not None
        and position.age_s <= MAX_AGE_S
        and position.lat_deg is not None
        and position.lon_deg is not None
    ):
        # From when the position was measured to when the picture was taken.
        time_s = position.age_s - age_s
        north_m = (position.velocity_north_m_s or 0.0) * time_s
        east_m = (position.velocity_east_m_s or 0.0) * time_s
        up_m = -(position.velocity_down_m_s or 0.0) * time_s
        lat_deg = position.lat_deg + math.degrees(north_m / EARTH_RADIUS_M)
        shrink = max(math.cos(math.radians(position.lat_deg)), 1e-6)
        lon_deg = position.lon_deg + math.degrees(east_m / (EARTH_RADIUS_M * shrink))
        values["lat_deg"], values["lon_deg"] = max(-90.0, min(90.0, lat_deg)), (lon_deg + 180.0) % 360.0 - 180.0
        values["alt_amsl_m"] = None if position.alt_amsl_m is None else position.alt_amsl_m + up_m
        values["alt_rel_home_m"] = None if position.alt_rel_home_m is None else position.alt_rel_home_m + up_m
    if attitude is not None and attitude.age_s <= MAX_AGE_S:
        values["roll_deg"] = _degrees(attitude.roll_rad)
        values["pitch_deg"] = _degrees(attitude.pitch_rad)
        yaw_deg = _degrees(attitude.yaw_rad)
        values["yaw_deg"] = None if yaw_deg is None else yaw_deg % 360.0
    return Pose(**values)


def _degrees(value_rad: float | None) -> float | None:
    return None if value_rad is None else math.degrees(value_rad)


def with_pose(data: bytes, captured_unix_s: float, pose: Pose) -> bytes:
    """A JPEG file with the time and the pose in it.

    Raises
    ------
    CameraError
        When Pillow is not installed.
    """
    return jpeg.with_segments(data, _exif(captured_unix_s, pose), XMP_HEADER + _xmp(pose).encode())


def _exif(captured_unix_s: float, pose: Pose) -> bytes:
    try:
        from PIL import Image
    except ImportError as error:
        raise CameraError("still pictures need the camera extra: pip install 'vencejo[camera]'") from error
    at = datetime.fromtimestamp(0, timezone.utc) + timedelta(seconds=captured_unix_s)
    exif = Image.Exif()
    exif[SOFTWARE] = "Vencejo"
    exif[DATE_TIME] = f"{at:%Y:%m:%d %H:%M:%S}"
    exif[EXIF_FOLDER] = {
        DATE_TIME_ORIGINAL: f"{at:%Y:%m:%d %H:%M:%S}",
        OFFSET_TIME_ORIGINAL: "+00:00",
        SUBSEC_TIME_ORIGINAL: f"{at.microsecond // 1000:03d}",
    }
    gps: dict[int, object] = {0: b"\x02\x03\x00\x00"}  # GPSVersionID
    if pose.lat_deg is not None and pose.lon_deg is not None:
        gps[1], gps[2] = "S" if pose.lat_deg < 0 else "N", _sexagesimal(pose.lat_deg)
        gps[3], gps[4] = "W" if pose.lon_deg < 0 else "E", _sexagesimal(pose.lon_deg)
        gps[18] = "WGS-84"  # GPSMapDatum
    if pose.alt_amsl_m is not None:
        gps[5], gps[6] = b"\x01" if pose.alt_amsl_m < 0 else b"\x00", _rational(abs(pose.alt_amsl_m), 1000)
    if pose.yaw_deg is not None:
        gps[16], gps[17] = "T", _rational(pose.yaw_deg, 100)  # GPSImgDirection, from true north
    gps[7] = (_rational(at.hour, 1), _rational(at.minute, 1), _rational(at.second + at.microsecond / 1e6, 1000))
    gps[29] = f"{at:%Y:%m:%d}"  # GPSDateStamp
    exif[GPS_FOLDER] = gps
    return exif.tobytes()


def _rational(value: float, denominator: int) -> object:
    from PIL.TiffImagePlugin import IFDRational

    return IFDRational(round(value * denominator), denominator)


def _sexagesimal(value_deg: float) -> tuple[object, object, object]:
    """Degrees, minutes and seconds, to a ten-thousandth of a second: 3 mm."""
    units = round(abs(value_deg) * 3600 * 10_000)
    minutes, rest = divmod(units, 60 * 10_000)
    return (_rational(minutes // 60, 1), _rational(minutes % 60, 1), _rational(rest / 10_000, 10_000))


def _xmp(pose: Pose) -> str:
    said = {
        "Camera:Roll": pose.roll_deg,
        "Camera:Pitch": pose.pitch_deg,
        "Camera:Yaw": pose.yaw_deg,
        "vencejo:AltitudeAboveHome": pose.alt_rel_home_m,
    }
    attributes = "".join(f" {name}={quoteattr(f'{value:.3f}')}" for name, value in said.items() if value is not None)
    return (
        '<?xpacket begin="\ufeff" id="W5M0MpCehiHzreSzNTczkc9d"?><x:xmpmeta xmlns:x="adobe:ns:meta/">'
        '<rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#"><rdf:Description rdf:about=""'
        ' xmlns:Camera="http://pix4d.com/camera/1.0/" xmlns:vencejo="urn:vencejo:xmp"'
        f'{attributes}/></rdf:RDF></x:xmpmeta><?xpacket end="r"?>'
    )
