"""A specimen of a user's script: a cube with a notch from above whose mouth is pushed apart."""

from collections.abc import Mapping
from dataclasses import dataclass

from cohesive import Scene, register_specimen, run
from meshing import Outline, PlaneSpecimen
from meshing.keys import key
from meshing.specimens import Drive, Support


@register_specimen("my-split-cube")
@dataclass(frozen=True)
class SplitCube(PlaneSpecimen):
    """Origin under the notch, on the base."""

    side: float = key("side and thickness of the cube", unit="mm", above=0)
    notch: float = key("depth of the notch, 4 mm wide", unit="mm", above=0)
    thickness = property(lambda self: self.side)
    paths = property(lambda self: [[(0.0, self.side - self.notch), (0.0, 0.0)]])

    def outline(self, half: bool = False) -> Outline:
        a, b, tip = self.side / 2, self.side, self.side - self.notch
        corners = [(-a, 0.0), (a, 0.0), (a, b), (2.0, b), (2.0, tip), (-2.0, tip), (-2.0, b), (-a, b)]
        return Outline(corners, self.paths, nodes={"left": [(-2.0, b)], "right": [(2.0, b)], "corner": [(-a, 0.0)]})

    def held(self, *, half: bool = False) -> list[Support]:
        return [Support("left"), Support("corner", (1.0, 0.0))]

    def drives(self, *, half: bool = False) -> Mapping[str, Drive]:
        return {"right": Drive("right", (1.0, 0.0))}


if __name__ == "__main__":
    cube = {"kind": "my-split-cube", "side": 100.0, "notch": 40.0}
    material = {"E": 30e3, "nu": 0.2, "ft": 3.0, "Gf": 0.1}
    stages = [{"control": "opening", "to": 0.1, "steps": 100}]
    print(run(Scene({"specimen": cube, "material": material, "stage": stages})).summary())
