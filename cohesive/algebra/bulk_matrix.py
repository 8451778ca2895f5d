"""Assembly of the elastic bulk."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from ..elements.bulk import ElasticBlock


def bulk_stiffness(blocks: Sequence[ElasticBlock], size: int) -> sp.csr_array:
    """Stiffness of the elastic bulk for the displacements of all nodes, (size, size), N/mm."""
    if not blocks:
        return sp.csr_array((size, size))
    rows, columns, values = [], [], []
    for block in blocks:
        dofs = block.dofs().astype(np.int32)
        K = block.stiffness()
        rows.append(np.broadcast_to(dofs[:, :, None], K.shape).ravel())
        columns.append(np.broadcast_to(dofs[:, None, :], K.shape).ravel())
        values.append(K.ravel())
    # the entries of a single block are not copied: they take more memory than the matrix
    value, row, column = (part[0] if len(part) == 1 else np.concatenate(part) for part in (values, rows, columns))
    return sp.coo_array((value, (row, column)), shape=(size, size)).tocsr()
