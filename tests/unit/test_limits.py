"""What the system allows a process."""

import subprocess
import sys
from pathlib import Path

import pytest

CODE = """
import resource
from multilayer.limits import memory_bounded
before = resource.getrlimit(resource.RLIMIT_AS)
with memory_bounded(200_000_000):
    bytearray(100_000_000)
    try:
        bytearray(400_000_000)
    except MemoryError:
        print("refused")
assert resource.getrlimit(resource.RLIMIT_AS) == before
bytearray(400_000_000)
"""


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="only Linux tells how much memory a process has")
def test_a_block_takes_no_more_memory_than_it_may():
    done = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True, check=True)
    assert done.stdout == "refused\n"
