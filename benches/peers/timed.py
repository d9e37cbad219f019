"""Runs a program and prints its wall time and peak resident memory as JSON.

A process of its own, since a child counts the memory of the process that it was forked from as its peak.
"""

import json
import os
import sys
import time

begun = time.perf_counter()
child = os.posix_spawnp(sys.argv[1], sys.argv[1:], os.environ, file_actions=[(os.POSIX_SPAWN_OPEN, 1, "/dev/null", os.O_WRONLY, 0)])
_, status, usage = os.wait4(child, 0)
print(json.dumps({"seconds": time.perf_counter() - begun, "mib": usage.ru_maxrss / 1024}))
sys.exit(os.waitstatus_to_exitcode(status))
