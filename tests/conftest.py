"""What every test may rely on, however pytest was started."""

import signal
import threading

# A shell starts background jobs with Ctrl-C ignored, and programs inherit that. Tests that press Ctrl-C start
# programs of their own; with a handler here those begin with the default again.
if threading.current_thread() is threading.main_thread() and signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
