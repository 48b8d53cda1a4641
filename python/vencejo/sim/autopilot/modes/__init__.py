"""The flight modes, by their subject; :mod:`.table` has all of them by number. AUTO is in :mod:`..auto`."""
