"""A control of a user's script: the opening less the sliding of the gauge, here on a crack that is sheared."""

from cohesive import Result, Scene, register_control, run
from cohesive.arrays import Array
from cohesive.solver.controls import LinearControl
from cohesive.solver.problem import Problem


@register_control("my-gauge")
class Slanted(LinearControl):
    """A gauge at 45 degrees to the crack measures opening and sliding together, mm."""

    def row(self, problem: Problem) -> Array:
        """The value is row @ unknowns."""
        return (problem.measures["opening"] + problem.measures["sliding"]) / 2**0.5


def main() -> Result:
    """Open a crack by the slanted gauge."""
    stage = [{"control": "my-gauge", "to": 0.05, "steps": 25}]
    return run(Scene.load("single-crack").with_(**{"specimen.angle": 20.0, "stage": stage}))


if __name__ == "__main__":
    print(main().summary())
