"""What your sensors cannot tell you: python rank.py SENSOR [SENSOR …]"""

from robot_perception.scripts import Kinds, installed, script
from robot_perception.slam import observability

with installed():
    import click
    import sympy

    from robot_perception.slam.observability import symbolic

LANDMARKS = 2  # in the map


class Distances:
    """A sensor of your own: how far the landmarks are, radio beacons perhaps, but not where."""

    def formula(self, x: sympy.MatrixBase) -> sympy.MatrixBase:
        offsets = [x[i : i + 2, :] - x[:2, :] for i in range(3, len(x), 2)]  # x: pose, landmarks
        return sympy.Matrix([d.dot(d) / 2 for d in offsets])  # half the square stays rational


SENSORS = {
    "landmarks": observability.Landmarks(observability.RANGE_BEARING),
    "anchor": symbolic.ANCHORS[0],  # a landmark at a known place
    "anchor2": symbolic.ANCHORS[1],
    "position": observability.Position(),
    "compass": observability.Heading(),
    "distances": Distances(),
}
KINDS = {
    "landmarks": "Distance and direction of landmarks at unknown places.",
    "anchor": "The same of a landmark at a known place.",
    "anchor2": "And of a second one.",
    "position": "Where the robot is.",
    "compass": "Where it heads.",
    "distances": "Distances of landmarks, without directions.",
}


@script
@click.argument("names", metavar="SENSOR...", type=Kinds(KINDS), nargs=-1, required=True)
def main(names):
    """What your sensors cannot tell you."""
    sensors = [SENSORS[name] for name in names]
    for analysis in (symbolic.trajectory_matrix, symbolic.lie_matrix):
        found = symbolic.read(analysis(sensors, LANDMARKS), sensors)
        more = found.dimension - found.rank - len(found.unseen)
        others = [f"{more} directions that are no motion of the whole world"] if more else []
        print(f"{analysis.__name__}: rank {found.rank} of {found.dimension}")
        print(f"  cannot be observed: {', '.join([*found.unseen, *others]) or 'nothing'}")


if __name__ == "__main__":
    main()
