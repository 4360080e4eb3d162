"""Names for the arrays that the package passes around."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.intp]
Bytes = NDArray[np.uint8]
Words = NDArray[np.uint16]
