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
    """That of one block, as the product of the elements' rows with their places: sorting all entries would take longer."""
    dofs, values = block.dofs().astype(np.int32), block.stiffness()
    columns = np.broadcast_to(dofs[:, None, :], values.shape)
    start = np.arange(0, values.size + 1, dofs.shape[1])
    rows = sp.csr_array((values.ravel(), columns.ravel(), start), shape=(dofs.size, size))
    place = sp.csr_array((np.ones(dofs.size), dofs.ravel(), np.arange(dofs.size + 1)), shape=(dofs.size, size))
    K: sp.csr_array = place.T.tocsr() @ rows
    K.sort_indices()
    return K
