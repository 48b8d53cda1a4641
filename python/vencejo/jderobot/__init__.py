"""The JdeRobot interfaces and the precise ones, on ZeroC Ice (docs/jderobot.md).

They need the extra ``vencejo[ice]``; without it this package imports, and `IceServer` says what to install.

Examples
--------
>>> from vencejo.jderobot import IceSettings
>>> IceSettings(host="127.0.0.1").endpoint("Pose3D")
'tcp -h 127.0.0.1 -p 9998'
"""

from vencejo.jderobot.server import IceServer
from vencejo.jderobot.settings import IceSettings, default_config_file, read_cfg, read_config

__all__ = ["IceServer", "IceSettings", "default_config_file", "read_cfg", "read_config"]
