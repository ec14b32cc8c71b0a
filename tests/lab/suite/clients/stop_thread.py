"""Stops one thread of a process, named, until the process is gone: a loop that hangs."""
import ctypes
import os
import sys
import time

SEIZE, INTERRUPT = 0x4206, 0x4207
pid, name = int(sys.argv[1]), sys.argv[2]
libc = ctypes.CDLL(None, use_errno=True)
libc.ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]
for thread in os.listdir(f"/proc/{pid}/task"):
    with open(f"/proc/{pid}/task/{thread}/comm") as comm:
        if comm.read().strip() == name:
            if libc.ptrace(SEIZE, int(thread), None, None) or libc.ptrace(INTERRUPT, int(thread), None, None):
                sys.exit(os.strerror(ctypes.get_errno()))
            break
else:
    sys.exit(f"no thread {name}")
while os.path.exists(f"/proc/{pid}/stat"):
    with open(f"/proc/{pid}/stat") as stat:
        if stat.read().rsplit(")", 1)[1].split()[0] in "ZX":
            break
    time.sleep(0.02)
