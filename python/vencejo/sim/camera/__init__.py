"""The simulated plane's nose camera: an IP camera like others, with pictures of the world as the true state shows it.

:mod:`view` is the geometry, :mod:`ground` and :mod:`airfield` are what there is to see, :mod:`render` paints it, :mod:`nose`
paces it while somebody looks and :mod:`http` serves it. It needs OpenCV: the extra ``vencejo[camera]``.
"""

from __future__ import annotations

__all__: list[str] = []
