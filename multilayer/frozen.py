"""Import this last: what is imported by then is not looked through for garbage any more.

In a process that others are forked from, and that ends sooner itself.
"""

import gc

gc.freeze()
