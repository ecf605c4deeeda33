"""Starts the node: ros2 launch taxel_ros taxel.launch.py model:=skin.safetensors topic:=/skin/pressures"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

# Name, kind, default and meaning of what is most often set; the others are in the file of parameters.
ARGUMENTS = [
    ("model", str, None, "the model file: .safetensors"),
    ("topic", str, None, "the topic to listen to"),
    ("type", str, "", "its type, where the topic is not there yet"),
    ("field", str, "", "a field of its messages; all numbers where it is empty"),
]


def generate_launch_description():
    file = PathJoinSubstitution([FindPackageShare("taxel_ros"), "config", "taxel.yaml"])
    declared = [DeclareLaunchArgument(name, default_value=default, description=says) for name, _, default, says in ARGUMENTS]
    declared.append(DeclareLaunchArgument("name", default_value="taxel", description="the name of the node"))
    declared.append(DeclareLaunchArgument("parameters", default_value=file, description="a file of parameters"))
    given = {name: ParameterValue(LaunchConfiguration(name), value_type=kind) for name, kind, _, _ in ARGUMENTS}
    node = Node(
        package="taxel_ros",
        executable="node",
        name=LaunchConfiguration("name"),
        parameters=[LaunchConfiguration("parameters"), given],
        output="screen",
    )
    return LaunchDescription([*declared, node])
