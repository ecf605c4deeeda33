"""A stand-in for ROS 2: as much of the interface of rclpy, its messages and its launch files as `taxel_ros` uses.

rclpy is no package of PyPI. What a message or a node refuses here, rclpy refuses: a field of another type, a parameter of another
type than its default, a level that is no byte, a relative name.
"""

from __future__ import annotations

import sys
import types
from array import array


class Message:
    """A message with typed fields: the kinds are `float`, `str`, `bytes`, another message, or a list of one of them."""

    KINDS: dict = {}

    def __init__(self, **values):
        for name, kind in self.KINDS.items():
            if isinstance(kind, list):
                object.__setattr__(self, name, array("f") if kind == [float] else [])
            else:
                object.__setattr__(self, name, kind() if kind is not bytes else b"\x00")
        for name, value in values.items():
            setattr(self, name, value)

    @classmethod
    def get_fields_and_field_types(cls):
        return {name: str(kind) for name, kind in cls.KINDS.items()}

    def __setattr__(self, name, value):
        kind = self.KINDS[name]
        if kind == [float]:
            assert all(isinstance(one, float) for one in value), f"{name}: a list of floats"
            value = array("f", value)
        elif isinstance(kind, list):
            assert all(isinstance(one, kind[0]) for one in value), f"{name}: a list of {kind[0].__name__}"
            value = list(value)
        else:
            assert isinstance(value, kind), f"{name}: {kind.__name__}, not {type(value).__name__}"
            assert kind is not bytes or len(value) == 1, f"{name}: one byte"
        object.__setattr__(self, name, value)


def message(_name: str, _constants: dict | None = None, **kinds) -> type[Message]:
    return type(_name, (Message,), {"KINDS": kinds, **(_constants or {})})


Time = message("Time", sec=int, nanosec=int)
Header = message("Header", stamp=Time, frame_id=str)
String = message("String", data=str)
MultiArrayDimension = message("MultiArrayDimension", label=str, size=int, stride=int)
MultiArrayLayout = message("MultiArrayLayout", dim=[MultiArrayDimension], data_offset=int)
Float32MultiArray = message("Float32MultiArray", layout=MultiArrayLayout, data=[float])
KeyValue = message("KeyValue", key=str, value=str)
LEVELS = {"OK": b"\x00", "WARN": b"\x01", "ERROR": b"\x02", "STALE": b"\x03"}
DiagnosticStatus = message("DiagnosticStatus", LEVELS, level=bytes, name=str, message=str, hardware_id=str, values=[KeyValue])
DiagnosticArray = message("DiagnosticArray", header=Header, status=[DiagnosticStatus])
JointState = message("JointState", header=Header, name=[str], position=[float], velocity=[float], effort=[float])
Vector3 = message("Vector3", x=float, y=float, z=float)
Wrench = message("Wrench", force=Vector3, torque=Vector3)
WrenchStamped = message("WrenchStamped", header=Header, wrench=Wrench)
ParameterDescriptor = message("ParameterDescriptor", description=str, read_only=bool)


class Trigger:
    Request = message("Trigger_Request")
    Response = message("Trigger_Response", success=bool, message=str)


TYPES = {
    "std_msgs/msg/Float32MultiArray": Float32MultiArray,
    "sensor_msgs/msg/JointState": JointState,
    "geometry_msgs/msg/WrenchStamped": WrenchStamped,
}


#: The packages that are stood in for.
MODULES = {
    "rclpy", "rcl_interfaces", "rosidl_runtime_py", "std_msgs", "std_srvs", "diagnostic_msgs", "launch", "launch_ros",
}


class World:
    """What runs outside of the node: parameters that were given, topics, what was published and logged."""

    def __init__(self):
        self.given, self.topics, self.published, self.logged = {}, {}, {}, []


world = World()


class Publisher:
    def __init__(self, kind, topic):
        self.kind, self.sent = kind, world.published.setdefault(topic, [])

    def publish(self, told):
        assert type(told) is self.kind, f"{self.kind.__name__}, not {type(told).__name__}"
        self.sent.append(told)


class Logger:
    def info(self, text, **_):
        world.logged.append(("info", text))

    def warning(self, text, throttle_duration_sec=None, **_):
        world.logged.append(("warning", text))


class Node:
    def __init__(self, node_name, **_):
        self.node_name, self.parameters, self.subscriptions, self.timers, self.services = node_name, {}, {}, [], {}

    def get_name(self):
        return self.node_name

    def resolve_topic_name(self, topic):
        if topic.startswith("~/"):
            return f"/{self.node_name}/{topic[2:]}"
        return topic if topic.startswith("/") else f"/{topic}"

    def declare_parameter(self, name, value, descriptor):
        assert isinstance(descriptor, ParameterDescriptor) and descriptor.description
        given = world.given.get(name, value)
        assert type(given) is type(value), f"InvalidParameterTypeException: {name}"
        self.parameters[name] = types.SimpleNamespace(value=given)

    def get_parameter(self, name):
        return self.parameters[name]

    def create_publisher(self, kind, topic, depth):
        assert isinstance(depth, int)
        return Publisher(kind, self.resolve_topic_name(topic))

    def create_subscription(self, kind, topic, hear, profile):
        assert profile.depth > 0 and issubclass(kind, Message)
        self.subscriptions[self.resolve_topic_name(topic)] = hear
        return hear

    def create_timer(self, seconds, tick):
        self.timers.append(tick)

    def create_service(self, kind, name, answer):
        self.services[self.resolve_topic_name(name)] = (kind, answer)

    def get_topic_names_and_types(self):
        return list(world.topics.items())

    def get_logger(self):
        return Logger()

    def get_clock(self):
        now = types.SimpleNamespace(to_msg=lambda: Time(sec=7, nanosec=5))
        return types.SimpleNamespace(now=lambda: now)


def get_message(kind):
    return TYPES[kind]


class QoSProfile:
    def __init__(self, *, depth, reliability):
        self.depth, self.reliability = depth, reliability


class Launched:
    """An action or a substitution of a launch file: what it was made of."""

    def __init__(self, *of, **how):
        self.of, self.how = of, how


def install(spin) -> World:
    """Puts the modules in place; `spin` runs a node. Returns the world of the next node."""
    global world
    world = World()

    def module(name, **held):
        made = types.ModuleType(name)
        made.__dict__.update(held)
        sys.modules[name] = made

    is_up = []
    module(
        "rclpy", init=lambda args=None: is_up.append(1), ok=lambda: bool(is_up), shutdown=is_up.clear, spin=spin,
    )
    module("rclpy.node", Node=Node)
    module("rclpy.executors", ExternalShutdownException=type("ExternalShutdownException", (Exception,), {}))
    module("rclpy.qos", QoSProfile=QoSProfile, ReliabilityPolicy=types.SimpleNamespace(RELIABLE=1, BEST_EFFORT=2))
    module("rcl_interfaces")
    module("rcl_interfaces.msg", ParameterDescriptor=ParameterDescriptor)
    module("rosidl_runtime_py")
    module("rosidl_runtime_py.utilities", get_message=get_message)
    module("std_msgs")
    module("std_msgs.msg", Float32MultiArray=Float32MultiArray, MultiArrayDimension=MultiArrayDimension, String=String)
    module("std_srvs")
    module("std_srvs.srv", Trigger=Trigger)
    module("diagnostic_msgs")
    module("diagnostic_msgs.msg", DiagnosticArray=DiagnosticArray, DiagnosticStatus=DiagnosticStatus, KeyValue=KeyValue)
    module("launch", LaunchDescription=list)
    module("launch.actions", DeclareLaunchArgument=Launched)
    module("launch.substitutions", LaunchConfiguration=Launched, PathJoinSubstitution=Launched)
    module("launch_ros")
    module("launch_ros.actions", Node=Launched)
    module("launch_ros.parameter_descriptions", ParameterValue=Launched)
    module("launch_ros.substitutions", FindPackageShare=Launched)
    return world
