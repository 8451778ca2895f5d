"""The one error of this package."""


class MeshError(ValueError):
    """A geometry or mesh that cannot be used; the message names the entity, the value and what was expected."""
