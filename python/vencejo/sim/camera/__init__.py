"""The simulated plane's nose camera: an IP camera with pictures rendered from the true state.

:mod:`view` is the geometry, :mod:`ground` and :mod:`airfield` are the scene, :mod:`render` paints it, :mod:`nose`
paces it while there are viewers and :mod:`http` serves it. It needs OpenCV: the extra ``vencejo[camera]``.
"""

from __future__ import annotations

__all__: list[str] = []
