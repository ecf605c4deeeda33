"""A node that turns a stream of readings into decisions.

From any program that prints a reading a line, its values separated by commas or blanks:

    python read_sensor.py | python node.py model.safetensors --early 0.95

or as a ROS 2 node (needs rclpy), from a topic of std_msgs/Float32MultiArray to one of std_msgs/String:

    python node.py model.safetensors --topic /finger/pressures --contact
"""

import argparse
import sys

import taxel


def from_lines(stream: taxel.Stream) -> None:
    for line in sys.stdin:
        if not line.strip():
            continue
        decision = stream.push([float(value) for value in line.replace(",", " ").split()])
        if decision:
            print(words(stream, decision), flush=True)


def from_topic(stream: taxel.Stream, topic: str) -> None:
    import rclpy
    from rclpy.node import Node
    from std_msgs.msg import Float32MultiArray, String

    class Decisions(Node):
        def __init__(self) -> None:
            super().__init__("taxel")
            self.out = self.create_publisher(String, f"{topic}/decision", 10)
            self.create_subscription(Float32MultiArray, topic, self.hear, 50)

        def hear(self, message: Float32MultiArray) -> None:
            decision = stream.push(message.data)
            if decision:
                self.out.publish(String(data=words(stream, decision)))

    rclpy.init()
    rclpy.spin(Decisions())


def words(stream: taxel.Stream, decision: taxel.Decision) -> str:
    """`149 shore-10 0.912`, and what is wrong with the channels; of a model of values `149 3.52 N`."""
    broken = "".join(f" {what}={getattr(decision, what)}" for what in ("dead", "stuck") if getattr(decision, what))
    if decision.values is not None:
        units = [unit or "" for unit in stream.model.units]
        values = ", ".join(f"{value:.4g} {unit}".strip() for value, unit in zip(decision.values.values(), units))
        return f"{decision.reading} {values}{broken}"
    return f"{decision.reading} {decision.answer} {decision.probabilities.max():.3f}{broken}"


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("model", help="a model file: .safetensors")
    arguments.add_argument("--hop", type=int, help="readings from one window to the next")
    arguments.add_argument("--early", type=float, help="the probability at which a window is decided before it is full")
    arguments.add_argument("--contact", action="store_true", help="windows begin with contact")
    arguments.add_argument("--topic", help="a ROS 2 topic in place of standard input")
    own = arguments.parse_args()
    stream = taxel.Stream(taxel.load(own.model), hop=own.hop, early=own.early, contact=own.contact)
    if own.topic:
        from_topic(stream, own.topic)
    else:
        from_lines(stream)


if __name__ == "__main__":
    main()
