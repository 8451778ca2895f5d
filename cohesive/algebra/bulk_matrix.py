"""Assembly of the elastic bulk."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from ..elements.bulk import ElasticBlock


def bulk_stiffness(blocks: Sequence[ElasticBlock], size: int) -> sp.csr_array:
    """Stiffness of the elastic bulk for the displacements of all nodes, (size, size), N/mm."""
    return sum((_assembled(block, size) for block in blocks), start=sp.csr_array((size, size)))


def _assembled(block: ElasticBlock, size: int) -> sp.csr_array:
    """That of one block."""
    dofs, values = block.dofs().astype(np.int32), block.stiffness()  # short indices, which are sorted in half the time
    rows, columns = (np.broadcast_to(each, values.shape).ravel() for each in (dofs[:, :, None], dofs[:, None, :]))
    return sp.coo_array((values.ravel(), (rows, columns)), shape=(size, size)).tocsr()
