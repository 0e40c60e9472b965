"""Launch the five nodes of the graph, each in its own process.

ros2 launch dp_bringup dp.launch.py vessel:=cybership3 params_file:=my_params.yaml simulate:=true namespace:=ship
"""

from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import LifecycleNode
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription

RING = ("dp_observer", "dp_controller", "thrust_allocator", "thruster_drivers")


def _node(package: str, **extra: object) -> LifecycleNode:
    # The nodes activate themselves; a supervisor that wants to do it sets autostart to false in the parameter file.
    return LifecycleNode(
        package=package,
        executable="node",
        name=package,
        namespace=LaunchConfiguration("namespace"),
        parameters=[LaunchConfiguration("params_file"), {"vessel": LaunchConfiguration("vessel")}],
        output="screen",
        **extra,
    )


def generate_launch_description() -> LaunchDescription:
    """Return the graph; ``simulate:=false`` leaves the simulator out, for a vessel that is there."""
    default_parameters = PathJoinSubstitution([FindPackageShare("dp_bringup"), "config", "defaults.yaml"])
    return LaunchDescription(
        [
            DeclareLaunchArgument("vessel", default_value="cybership3", description="Name or path of the vessel file"),
            DeclareLaunchArgument("namespace", default_value="", description="Namespace of the whole graph"),
            DeclareLaunchArgument("simulate", default_value="true", description="Run the simulated vessel"),
            DeclareLaunchArgument(
                "params_file", default_value=default_parameters, description="Parameters of all nodes"
            ),
            *(_node(package) for package in RING),
            _node("vessel_sim", condition=IfCondition(LaunchConfiguration("simulate"))),
        ]
    )
