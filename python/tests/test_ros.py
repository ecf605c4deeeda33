"""The ROS 2 package, against a stand-in for rclpy: no distribution of it is on PyPI."""

import importlib
import importlib.util
import json
import sys
import xml.etree.ElementTree as xml
from pathlib import Path

import numpy as np
import pytest
import ros_stand_in as ros
import taxel

PACKAGE = Path(__file__).resolve().parents[1] / "ros2" / "taxel_ros"


@pytest.fixture
def world(monkeypatch):
    """The world of a node that is not made yet; the package is imported anew, so that it sees this one."""
    monkeypatch.syspath_prepend(str(PACKAGE))
    before = set(sys.modules)
    yield ros.install(lambda node: None)
    for name in set(sys.modules) - before:
        if name.split(".")[0] in ros.MODULES | {"taxel_ros"}:
            del sys.modules[name]


@pytest.fixture
def model(mlp, tmp_path):
    path = tmp_path / "mlp.safetensors"
    mlp.save(path)
    return str(path)


def node(world, **given):
    world.given.update(given)
    return importlib.import_module("taxel_ros.node").TaxelNode()


def hear(own, topic, values, at=0.0, kind=ros.Float32MultiArray, **more):
    told = kind(data=[float(value) for value in values]) if kind is ros.Float32MultiArray else kind(**more)
    own.subscriptions[topic](told)


def status(own, world):
    own.timers[0]()
    return world.published["/diagnostics"][-1].status[0]


def test_decisions_are_those_of_the_stream(world, model, mlp, grasps):
    world.topics["/skin"] = ["std_msgs/msg/Float32MultiArray"]
    own = node(world, model=model, topic="skin", hop=10)
    readings = np.concatenate(grasps.x[:2], axis=1).T
    for reading in readings:
        hear(own, "/skin", reading)
    wanted = list(taxel.Stream(mlp, hop=10, unknown=0.05).feed(readings))
    classes, shares = world.published["/taxel/class"], world.published["/taxel/probabilities"]
    assert [told.data for told in classes] == ["unknown" if one.unknown else one.answer for one in wanted] and len(wanted) == 6
    for told, one in zip(shares, wanted):
        assert np.allclose(told.data, one.probabilities)
        assert [dim.label for dim in told.layout.dim] == list(mlp.model_.classes)
    told = status(own, world)
    assert told.level in (ros.DiagnosticStatus.OK, ros.DiagnosticStatus.WARN)
    assert {one.key: one.value for one in told.values}["readings"] == "100"


def test_a_topic_that_comes_later_is_found(world, model):
    own = node(world, model=model, topic="/skin")
    told = status(own, world)
    assert told.level == ros.DiagnosticStatus.ERROR and "nobody publishes /skin" in told.message
    world.topics["/skin"] = ["std_msgs/msg/Float32MultiArray"]
    assert status(own, world).level == ros.DiagnosticStatus.STALE
    assert "/skin" in own.subscriptions


def test_fields_are_found_by_name(world):
    fields = importlib.import_module("taxel_ros.fields")
    told = ros.WrenchStamped(wrench=ros.Wrench(force=ros.Vector3(x=1.0, y=2.0, z=3.0), torque=ros.Vector3(x=4.0, y=5.0, z=6.0)))
    told.header.stamp.sec = 9
    joint = ros.JointState(name=["a", "b"], position=[1.0, 2.0], effort=[3.0, 4.0])
    for field, message, wanted in [
        ("", told, [1, 2, 3, 4, 5, 6]),
        ("wrench.force", told, [1, 2, 3]),
        ("wrench.torque.y", told, [5]),
        ("effort", joint, [3, 4]),
        ("effort[1]", joint, [4]),
        ("position[0:1]", joint, [1]),
    ]:
        assert fields.numbers(message, fields.path(field)) == wanted, field
    assert fields.stamp(told) == 9 and fields.stamp(ros.String()) is None
    for field, why in [("wrench.nosuch", "it has force, torque"), ("wrench..force", "is no field"), ("header.frame_id", "no numbers")]:
        with pytest.raises(fields.FieldError, match=why):
            fields.numbers(told, fields.path(field))
    with pytest.raises(fields.FieldError, match="no \\[7\\]"):
        fields.numbers(joint, fields.path("effort[7]"))


@pytest.fixture
def named(tmp_path, grasps):
    """A model whose channels have names, and whose recordings had a rate."""
    data = tmp_path / "grasps.npz"
    classes, labels = np.unique(grasps.y, return_inverse=True)
    np.savez(data, x=grasps.x, y=labels.astype("i8"))
    facts = {"layout": "series", "channels": list("abcde"), "classes": classes.tolist(), "rate": 100.0}
    (tmp_path / "labels.json").write_text(json.dumps(facts))
    fitted = taxel.Classifier("mlp", recipe={"epochs": 1}).fit(taxel.read(data))
    fitted.save(tmp_path / "named.safetensors")
    return fitted


def test_joints_are_matched_by_name(world, tmp_path, grasps, named):
    own = node(world, model=str(tmp_path / "named.safetensors"), topic="/joints", type="sensor_msgs/msg/JointState", field="effort")
    turned = [4, 2, 0, 1, 3]
    for reading in grasps.x[0].T:
        own.subscriptions["/joints"](ros.JointState(name=["abcde"[i] for i in turned], effort=[float(reading[i]) for i in turned]))
    probabilities = world.published["/taxel/probabilities"][-1].data
    assert np.allclose(probabilities, named.predict_proba(grasps.x[:1])[0])
    own.subscriptions["/joints"](ros.JointState(name=list("abcdx"), effort=[0.0] * 5))
    told = status(own, world)
    assert told.level == ros.DiagnosticStatus.ERROR and "there is no 'e'" in told.message


def test_what_is_wrong_is_said_and_ends_nothing(world, model, grasps):
    own = node(world, model=model, topic="/skin", type="std_msgs/msg/Float32MultiArray", hop=50)
    hear(own, "/skin", [1.0, 2.0])
    assert status(own, world).message == "a reading has 5 values; this one has 2"
    hear(own, "/skin", [float("nan")] * 5)
    assert "not finite" in status(own, world).message
    assert len(world.logged) >= 2
    for reading in grasps.x[0].T:
        hear(own, "/skin", [*reading[:4], 3.0])
    assert len(world.published["/taxel/class"]) == 1
    told = status(own, world)
    assert told.level == ros.DiagnosticStatus.WARN and "4" in told.message
    assert {one.key: one.value for one in told.values}["refused"] == "2"
    kind, answer = own.services["/taxel/tare"]
    said = answer(kind.Request(), kind.Response())
    assert not said.success and "what the sensor gives" in said.message


def test_a_gap_begins_the_window_anew(world, model, grasps):
    own = node(world, model=model, topic="/joints", type="sensor_msgs/msg/JointState", field="effort")
    readings = np.concatenate(grasps.x[:2], axis=1).T

    def send(first, last, offset=0.0):
        for i in range(first, last):
            seconds = 10 + 0.01 * i + offset
            told = ros.JointState(effort=[float(value) for value in readings[i]])
            told.header.stamp = ros.Time(sec=int(seconds), nanosec=int(1e9 * (seconds % 1)))
            own.subscriptions["/joints"](told)

    send(0, 40)
    send(40, 80, offset=1.0)
    assert "/taxel/class" in world.published and not world.published["/taxel/class"], "40 readings on each side of a gap are no window"
    send(80, 90, offset=1.0)
    assert len(world.published["/taxel/class"]) == 1
    assert {one.key: one.value for one in status(own, world).values}["gaps"] == "1"


def test_another_rate_is_said(world, tmp_path, named):
    own = node(world, model=str(tmp_path / "named.safetensors"), topic="/joints", type="sensor_msgs/msg/JointState", field="effort")
    for i in range(40):
        seconds = 10 + i / 50
        told = ros.JointState(effort=[1.0] * 5)
        told.header.stamp = ros.Time(sec=int(seconds), nanosec=int(1e9 * (seconds % 1)))
        own.subscriptions["/joints"](told)
    said = [text for kind, text in world.logged if kind == "warning"]
    assert len(said) == 1 and "readings come at 50.0 Hz, the model has learned them at 100.0 Hz" in said[0]


def test_values_have_units(world, tmp_path, grasps):
    force = grasps.x[:, 0, -1].astype("f4") + 0.5
    fitted = taxel.Regressor("deep-mlp", recipe={"epochs": 1}).fit(grasps.x, force)
    fitted.save(tmp_path / "force.safetensors")
    own = node(world, model=str(tmp_path / "force.safetensors"), topic="/skin", type="std_msgs/msg/Float32MultiArray", unknown=0.0)
    for reading in grasps.x[0].T:
        hear(own, "/skin", reading)
    value = world.published["/taxel/probabilities"][-1].data[0]
    assert world.published["/taxel/class"][-1].data.split()[0] == f"{value:.4g}"


def test_parameters_are_refused_in_words(world, model):
    for given, why in [({}, "model is empty"), ({"model": model}, "topic is empty"), ({"model": model, "topic": "/a", "field": "a b"}, "no field")]:
        with pytest.raises(ValueError, match=why):
            node(world, **given)
    main = importlib.import_module("taxel_ros.node").main
    world.given.clear()
    with pytest.raises(SystemExit, match="taxel_ros: the parameter model is empty"):
        main()


def test_the_package_agrees_with_itself(world):
    """Launch file, parameters, package.xml and setup.py name the same things."""
    spec = importlib.util.spec_from_file_location("taxel_launch", PACKAGE / "launch" / "taxel.launch.py")
    launch = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(launch)
    *declared, started = launch.generate_launch_description()
    names = [name for name, _, _ in importlib.import_module("taxel_ros.node").PARAMETERS]
    assert set(started.how["parameters"][1]) <= set(names)
    assert {one.of[0] for one in declared} == set(started.how["parameters"][1]) | {"name", "parameters"}
    lines = (PACKAGE / "config" / "taxel.yaml").read_text().splitlines()
    assert [line.split(":")[0].strip() for line in lines if line.startswith(" " * 4) and ":" in line] == names
    tree = xml.parse(PACKAGE / "package.xml").getroot()
    needs = {one.text for one in tree.findall("exec_depend")}
    source = (PACKAGE / "taxel_ros" / "node.py").read_text() + (PACKAGE / "launch" / "taxel.launch.py").read_text()
    assert tree.findtext("export/build_type") == "ament_python"
    assert needs == {"diagnostic_msgs", "launch", "launch_ros", "rclpy", "rosidl_runtime_py", "std_msgs", "std_srvs"}
    assert all(name in source for name in needs)
    setup = (PACKAGE / "setup.py").read_text()
    assert f'version="{tree.findtext("version")}"' in setup and "node = taxel_ros.node:main" in setup
    assert (PACKAGE / "resource" / "taxel_ros").exists()
