"""A taxel model as a ROS 2 node."""
