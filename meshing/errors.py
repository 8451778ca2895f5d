"""The one error of this package."""


class MeshError(ValueError):
    """A geometry or mesh that cannot be used; the message names the entity, the value and what was expected.

    Attributes
    ----------
    key : dotted scene key ("mesh.order", "band.width") or a specimen's own key ("crack", "file") that the message begins
        with; "" if it names none.
    """

    def __init__(self, message: str, key: str = "") -> None:
        super().__init__(message)
        self.key = key
