"""Import this last in a process that others are forked from: its objects are left out of garbage collection.

Collections in the forked processes then neither scan them nor copy the memory pages that they share.
"""

import gc

gc.freeze()
