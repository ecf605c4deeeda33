"""Installs the package as ament_python wants it."""

from glob import glob

from setuptools import setup

setup(
    name="taxel_ros",
    version="0.1.0",
    packages=["taxel_ros"],
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/taxel_ros"]),
        ("share/taxel_ros", ["package.xml"]),
        ("share/taxel_ros/launch", glob("launch/*.launch.py")),
        ("share/taxel_ros/config", glob("config/*.yaml")),
    ],
    # taxel itself is a wheel and no ROS package.
    install_requires=["setuptools", "taxel"],
    zip_safe=True,
    maintainer="the authors of taxel",
    maintainer_email="taxel@example.org",
    description="A taxel model as a ROS 2 node: classes and probabilities of any numeric topic",
    license="MIT OR Apache-2.0",
    entry_points={"console_scripts": ["node = taxel_ros.node:main"]},
)
