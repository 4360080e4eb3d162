"""Names for the arrays that the package passes around."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.intp]
Integers = NDArray[np.signedinteger[Any]]
Bytes = NDArray[np.uint8]
Words = NDArray[np.uint16]
