"""A node that listens to a numeric topic and publishes the decisions of a taxel model.

    ros2 run taxel_ros node --ros-args -p model:=skin.safetensors -p topic:=/skin/pressures -p field:=data

Publishes, below its own name:

    ~/class          std_msgs/String              the likeliest class, or `unknown`; of values, `3.52 N`
    ~/probabilities  std_msgs/Float32MultiArray   one for each class, whose name is the label of its dimension; of values these
    /diagnostics     diagnostic_msgs/DiagnosticArray  once a second: readings, decisions, latency, channels with a fault

Offers `~/tare` (std_srvs/Trigger): the sensor is at rest, take the level at rest anew.
"""

from __future__ import annotations

import statistics
import time
from typing import Any

import rclpy
import taxel
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosidl_runtime_py.utilities import get_message
from std_msgs.msg import Float32MultiArray, MultiArrayDimension, String
from std_srvs.srv import Trigger

from .fields import FieldError, joints, numbers, path, stamp

#: Readings that may wait for the node.
WAITING = 1000
#: Seconds between diagnostics, and between two looks for a topic that is not there yet.
PERIOD = 1.0
#: Steps whose median is the usual one; a step this many times as long is a gap.
STEPS, GAP = 16, 1.5
#: How much the rate may differ from that of the training, as a share.
OFF = 0.1

#: Name, default and meaning of each parameter.
PARAMETERS = [
    ("model", "", "the model file: .safetensors"),
    ("topic", "", "the topic to listen to"),
    ("type", "", "the type of its messages, such as sensor_msgs/msg/JointState; found by itself where it is published"),
    ("field", "", "a field of its messages: effort, wrench.force, data[0:5]; all numbers where it is empty"),
    ("hop", 0, "readings from one window to the next; 0 for a quarter of a window"),
    ("early", 0.0, "the probability at which a window is decided before it is full; 0 for never"),
    ("contact", False, "whether windows begin with contact"),
    ("unknown", 0.05, "the familiarity up to which a window is unknown; 0 for never"),
    ("full_scale", 0.0, "the largest possible reading; 0 for what the model says"),
    ("tare_steps", 0, "first readings at rest; 0 for as many as in training"),
    ("reliable", False, "asks for reliable delivery; sensors offer best effort"),
    ("frame_id", "", "the frame of the header of diagnostics"),
]


class TaxelNode(Node):
    """Subscribes a numeric topic, publishes what a model says of it."""

    def __init__(self, **options: Any) -> None:
        super().__init__("taxel", **options)
        for name, default, says in PARAMETERS:
            self.declare_parameter(name, default, ParameterDescriptor(description=says, read_only=True))
        own = {name: self.get_parameter(name).value for name, _, _ in PARAMETERS}
        for name in ("model", "topic"):
            if not own[name]:
                raise ValueError(f"the parameter {name} is empty; say -p {name}:=...")
        self.topic, self.kind, self.frame = own["topic"], own["type"], own["frame_id"]
        self.path = path(own["field"])
        self.reliable = own["reliable"]
        self.stream = taxel.Stream(
            taxel.load(own["model"]),
            hop=own["hop"] or None,
            early=own["early"] or None,
            contact=own["contact"],
            unknown=own["unknown"],
            full_scale=own["full_scale"] or None,
            tare=own["tare_steps"] or None,
        )
        spec = self.stream.model.card["reading"]
        self.channels, self.rate = spec.get("channel_names") or [], spec.get("rate")
        self.out = self.create_publisher(String, "~/class", 10)
        self.shares = self.create_publisher(Float32MultiArray, "~/probabilities", 10)
        self.diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_service(Trigger, "~/tare", self.tare)
        self.create_timer(PERIOD, self.tell)
        self.subscription: Any = None
        self.readings = self.decisions = self.refused = self.gaps = 0
        self.trouble, self.broken, self.latencies = "", {}, []
        self.last: float | None = None
        self.steps: list[float] = []
        self.look()

    def look(self) -> None:
        """Subscribes as soon as the type of the topic is known."""
        if self.subscription is not None:
            return
        kinds = [self.kind] if self.kind else dict(self.get_topic_names_and_types()).get(self.resolved(), [])
        if not kinds:
            self.trouble = f"nobody publishes {self.topic} yet, so its type is not known; say -p type:=..."
            return
        if len(kinds) > 1:
            self.trouble = f"{self.topic} has several types, {', '.join(kinds)}; say -p type:=..."
            return
        profile = QoSProfile(
            depth=WAITING,
            reliability=ReliabilityPolicy.RELIABLE if self.reliable else ReliabilityPolicy.BEST_EFFORT,
        )
        self.subscription = self.create_subscription(get_message(kinds[0]), self.topic, self.hear, profile)
        self.trouble = ""
        self.get_logger().info(f"{self.topic} ({kinds[0]}): {self.stream.values} values, windows of {self.stream.window}")

    def resolved(self) -> str:
        return self.resolve_topic_name(self.topic)

    def hear(self, message: Any) -> None:
        """Takes a message; a wrong one is counted and said, and ends nothing."""
        begun = time.perf_counter()
        try:
            values = self.in_order(message, numbers(message, self.path))
            self.watch(stamp(message))
            self.readings += 1
            decision = self.stream.push(values)
        except (FieldError, ValueError) as error:
            self.refused += 1
            self.trouble = str(error)
            self.get_logger().warning(f"{self.topic}: {error}", throttle_duration_sec=10.0)
            return
        self.trouble = ""
        if decision is not None:
            self.publish(decision)
            self.latencies.append(1e3 * (time.perf_counter() - begun))

    def in_order(self, message: Any, values: list[float]) -> list[float]:
        """The values in the order of the model's channels, where both have names."""
        names = joints(message, self.path)
        if not names or len(names) != len(values) or not self.channels:
            return values
        by_name = dict(zip(names, values))
        # A model that was trained on a bag names its channels by topic and field.
        wanted = [channel.rsplit(".", 1)[-1] for channel in self.channels]
        if not set(wanted) & set(by_name):
            return values
        missing = [name for name in wanted if name not in by_name]
        if missing:
            raise FieldError(f"there is no {missing[0]!r}, which the model reads; there are {', '.join(names)}")
        return [by_name[name] for name in wanted]

    def watch(self, now: float | None) -> None:
        """Looks for gaps: half a window or more begins the window anew."""
        last, self.last = self.last, now
        if now is None or last is None:
            return
        step = now - last
        if len(self.steps) < STEPS:
            if step > 0:
                self.steps.append(step)
            if len(self.steps) == STEPS and self.rate and abs(self.own_rate() / self.rate - 1) > OFF:
                self.get_logger().warning(f"readings come at {self.own_rate():.1f} Hz, the model has learned them at {self.rate} Hz")
            return
        usual = statistics.median(self.steps)
        if step <= 0 or step > GAP * usual:
            self.gaps += 1
            if step <= 0 or step / usual >= self.stream.window / 2:
                self.stream.anew()

    def own_rate(self) -> float:
        return 1 / statistics.median(self.steps)

    def publish(self, decision: taxel.Decision) -> None:
        self.decisions += 1
        model = self.stream.model
        self.broken = {what: getattr(decision, what) for what in ("dead", "stuck", "saturated") if getattr(decision, what)}
        if decision.values is not None:
            labels, shares = list(decision.values), list(decision.values.values())
            units = [unit or "" for unit in model.units]
            words = ", ".join(f"{value:.4g} {unit}".strip() for value, unit in zip(shares, units))
        else:
            several = len(model.attributes) > 1
            labels = [f"{name}/{one}" if several else str(one) for name, all in model.attributes.items() for one in all]
            shares = [float(share) for share in decision.probabilities]
            answers = decision.answer if isinstance(decision.answer, tuple) else (decision.answer,)
            words = ", ".join(map(str, answers))
        self.out.publish(String(data="unknown" if decision.unknown else words))
        array = Float32MultiArray()
        array.layout.dim = [MultiArrayDimension(label=label, size=1, stride=1) for label in labels]
        array.data = shares
        self.shares.publish(array)

    def tell(self) -> None:
        """Publishes how it goes."""
        self.look()
        status = DiagnosticStatus(name=f"{self.get_name()}: {self.topic}", hardware_id=self.stream.model.name)
        status.level, status.message = DiagnosticStatus.OK, "decisions as they come"
        if self.broken:
            words = (f"{what}: {', '.join(self.called(at) for at in channels)}" for what, channels in self.broken.items())
            status.level, status.message = DiagnosticStatus.WARN, "; ".join(words)
        if self.trouble:
            status.level, status.message = DiagnosticStatus.ERROR, self.trouble
        elif not self.readings:
            status.level, status.message = DiagnosticStatus.STALE, "no reading has come"
        middle = f"{statistics.median(self.latencies):.3f}" if self.latencies else ""
        counts = {
            "readings": self.readings, "decisions": self.decisions, "refused": self.refused, "gaps": self.gaps,
            "latency_ms": middle, "rate_hz": f"{self.own_rate():.1f}" if len(self.steps) == STEPS else "",
        }
        status.values = [KeyValue(key=key, value=str(value)) for key, value in counts.items()]
        self.latencies = []
        told = DiagnosticArray(status=[status])
        told.header.stamp = self.get_clock().now().to_msg()
        told.header.frame_id = self.frame
        self.diagnostics.publish(told)

    def called(self, channel: int) -> str:
        return self.channels[channel] if channel < len(self.channels) else str(channel)

    def tare(self, _: Any, response: Any) -> Any:
        response.success = self.stream.tare()
        response.message = "the next readings are at rest" if response.success else "the model reads what the sensor gives"
        return response


def main(args: list[str] | None = None) -> None:
    rclpy.init(args=args)
    try:
        rclpy.spin(TaxelNode())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except (ValueError, OSError) as error:
        raise SystemExit(f"taxel_ros: {error}") from error
    finally:
        if rclpy.ok():
            rclpy.shutdown()


if __name__ == "__main__":
    main()
