"""What ground stations ask, and what they get; commands only if they are allowed."""

import struct
from dataclasses import replace

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

from hil_bridge import frames
from hil_bridge.ground.settings import Pointing

from .ground import Ground, Station, matrix, orbiting, parameter, values

ACCEPTED, LATER, DENIED, UNSUPPORTED = 0, 1, 2, 3
POINT = Pointing("command.q_CN", "command.omega_CN_C", "command.engaged")


@pytest.fixture
def open_station(settings, rng):
    """Everything allowed; a symmetric matrix, an integer and a gain as parameters."""
    J = [[10.0, 1.0, 0.5], [1.0, 20.0, 1.5], [0.5, 1.5, 30.0]]
    table = [
        parameter(
            f"J_{i + 1}{k + 1}", "plant.J", 3 * i + k, f"plant.J[{i + 1},{k + 1}]", value=J[i][k], low=-1e9, high=1e9
        )
        for i in range(3)
        for k in range(3)
    ]
    table += [parameter("CTRL_K_P", "controller.k_p"), parameter("COUNT", "a.n", whole=True, value=2.0)]
    allowed = replace(settings, parameters=table, allow=["arm", "param", "attitude"], arm="switch.enabled", point=POINT)
    station = Station(allowed)
    station.show(values(rng))
    return station


def set_parameter(station, id_, value):
    before = len(station.asked)
    station.send(mavlink.MAVLink_param_set_message(1, 1, id_.encode(), value, mavlink.MAV_PARAM_TYPE_REAL32))
    return station.asked[before:]


def test_a_new_ground_station_is_told_what_this_is(station):
    station.send(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
    assert "adcs: test" in station.ground.texts
    assert "Allowed: nothing: read-only" in station.ground.texts
    n = len(station.ground.texts)
    station.send(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
    assert len(station.ground.texts) == n
    station.now += 11  # it was away
    station.send(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
    assert len(station.ground.texts) > n


def test_all_parameters_are_listed(open_station):
    open_station.send(mavlink.MAVLink_param_request_list_message(1, 1))
    found = open_station.ground.of("PARAM_VALUE")
    assert [p.param_index for p in found] == list(range(11))
    assert {p.param_count for p in found} == {11}
    assert found[9].param_id == "CTRL_K_P" and found[9].param_value == 1.5


@pytest.mark.parametrize(
    ("id_", "index", "expected"), [("CTRL_K_P", -1, "CTRL_K_P"), ("", 0, "J_11"), ("NO", -1, None)]
)
def test_one_parameter_is_read_by_name_or_index(open_station, id_, index, expected):
    open_station.send(mavlink.MAVLink_param_request_read_message(1, 1, id_.encode(), index))
    found = open_station.ground.of("PARAM_VALUE")
    assert [p.param_id for p in found] == ([] if expected is None else [expected])


def test_without_permission_nothing_changes(station, rng):
    station.show(values(rng))
    assert set_parameter(station, "CTRL_K_P", 2.0) == []
    assert station.ground.last("PARAM_VALUE").param_value == 1.5
    assert "Read-only: start with --allow param" in station.ground.texts
    assert station.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0) == DENIED
    assert station.command(mavlink.MAV_CMD_DO_SET_MODE, 33, 6) == DENIED
    station.send(target([1, 0, 0, 0]))
    assert station.asked == []


def test_a_parameter_is_set_when_the_simulation_says_so(open_station):
    ((number, kind, changes, source),) = set_parameter(open_station, "CTRL_K_P", np.float32(0.1))
    assert (kind, changes, source) == ("param", [("controller.k_p", [0.1])], "test")  # not 0.10000000149
    assert open_station.ground.of("PARAM_VALUE") == []
    said = open_station.vehicle.answered(number, None)
    open_station.vehicle.flush(open_station.ground.peer)
    assert open_station.ground.last("PARAM_VALUE").param_value == pytest.approx(0.1)
    assert [m.text for m in said] == [b"controller.k_p = 0.1 N.m"] or said[0].text == "controller.k_p = 0.1 N.m"


def test_a_parameter_that_the_component_refuses_keeps_its_value(open_station):
    ((number, *_),) = set_parameter(open_station, "CTRL_K_P", 0.0)
    said = open_station.vehicle.answered(number, "k_p must be above 0")
    open_station.vehicle.flush(open_station.ground.peer)
    assert open_station.ground.last("PARAM_VALUE").param_value == 1.5
    assert said[0].severity == mavlink.MAV_SEVERITY_ERROR


@pytest.mark.parametrize(
    ("id_", "value", "text"),
    [
        ("CTRL_K_P", -1.0, "CTRL_K_P = -1: expected a number from 0 to 10"),
        ("CTRL_K_P", 1e30, "CTRL_K_P = 1e+30: expected a number from 0 to 10"),
        ("CTRL_K_P", float("nan"), "CTRL_K_P = nan: not finite"),
        ("CTRL_K_P", float("inf"), "CTRL_K_P = inf: not finite"),
        ("COUNT", 2.5, "COUNT = 2.5: expected an integer"),
        ("NOTHING", 1.0, "No parameter NOTHING"),
    ],
)
def test_values_out_of_range_are_refused(open_station, id_, value, text):
    assert set_parameter(open_station, id_, value) == []
    assert text in open_station.ground.texts


def test_integers_as_bytes_of_a_float_are_refused(open_station):
    message = mavlink.MAVLink_param_set_message(1, 1, b"COUNT", 4.2e-45, mavlink.MAV_PARAM_TYPE_INT32)
    open_station.send(message)
    assert open_station.asked == []
    assert "COUNT: all parameters are of type REAL32" in open_station.ground.texts


def test_a_symmetric_matrix_stays_symmetric(open_station):
    ((number, _, changes, _),) = set_parameter(open_station, "J_12", 1.25)
    assert changes == [("plant.J", [10.0, 1.25, 0.5, 1.25, 20.0, 1.5, 0.5, 1.5, 30.0])]
    open_station.vehicle.answered(number, None)
    open_station.vehicle.flush(open_station.ground.peer)
    assert [p.param_id for p in open_station.ground.of("PARAM_VALUE")] == ["J_12", "J_21"]


def test_a_change_does_not_take_back_one_that_is_on_its_way(open_station):
    set_parameter(open_station, "J_11", 12.0)
    set_parameter(open_station, "J_12", 1.25)
    ((_, _, changes, _),) = set_parameter(open_station, "J_22", 22.0)
    assert changes == [("plant.J", [12.0, 1.25, 0.5, 1.25, 22.0, 1.5, 0.5, 1.5, 30.0])]
    number = open_station.asked[-3][0]
    open_station.vehicle.answered(number, "refused")  # the first: what follows is asked for without it
    ((_, _, changes, _),) = set_parameter(open_station, "J_33", 31.0)
    assert changes == [("plant.J", [10.0, 1.25, 0.5, 1.25, 22.0, 1.5, 0.5, 1.5, 31.0])]


def test_arming_closes_the_control_loop(open_station):
    assert open_station.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0) == ACCEPTED
    assert open_station.asked[-1][2] == [("switch.enabled", 0)]
    assert not open_station.vehicle.heartbeat().base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED
    assert "Disarmed: control torque is zero" in open_station.ground.texts
    assert open_station.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1) == ACCEPTED
    assert open_station.asked[-1][2] == [("switch.enabled", 1)]


def target(q, rates=(0.0, 0.0, 0.0), mask=7):
    return mavlink.MAVLink_set_attitude_target_message(0, 1, 1, mask, list(q), *rates, 0.0)


def test_a_commanded_attitude_goes_to_the_simulation_in_its_own_frame(settings, rng):
    station = Station(orbiting(settings, allow=["attitude"], point=POINT))
    station.show(values(rng, orbit=True), t=50.0)
    q_CF = frames.unit(rng.normal(size=4))
    station.send(target(q_CF))
    (name, q_CN), *others = station.asked[-1][2]
    assert name == "command.q_CN"
    C = matrix(q_CN) @ matrix(station.vehicle.state.q_FN).T  # C_CF = C_CN C_FN^T
    assert np.abs(C - matrix(q_CF)).max() < 5e-7  # float32 on its way
    assert others == [("command.omega_CN_C", [0.0, 0.0, 0.0]), ("command.engaged", 1)]
    station.send(target(q_CF, (0.1, 0.2, 0.3), mask=2))
    rate = dict(station.asked[-1][2])["command.omega_CN_C"]
    assert np.allclose(rate, [0.1, 0.0, 0.3])


def test_a_commanded_attitude_times_out(open_station):
    open_station.send(target([1, 0, 0, 0]))
    assert open_station.vehicle.pointing
    assert open_station.vehicle.tick(open_station.now + 0.9) == []
    said = open_station.vehicle.tick(open_station.now + 1.1)
    assert said and not open_station.vehicle.pointing
    assert open_station.asked[-1][2] == [("command.engaged", 0)]


def test_offboard_mode_wants_a_target_first(open_station):
    assert open_station.command(mavlink.MAV_CMD_DO_SET_MODE, 33, 6) == LATER
    open_station.send(target([1, 0, 0, 0]))
    assert open_station.command(mavlink.MAV_CMD_DO_SET_MODE, 33, 6) == ACCEPTED
    assert open_station.command(mavlink.MAV_CMD_DO_SET_MODE, 33, 4) == ACCEPTED  # and back
    assert open_station.asked[-1][2] == [("command.engaged", 0)]


@pytest.mark.parametrize("q", [[0, 0, 0, 0], [float("nan"), 0, 0, 0], [2, 0, 0, 0], [float("inf"), 0, 0, 1]])
def test_what_is_no_attitude_is_ignored(open_station, q):
    open_station.send(target(q))
    assert open_station.asked == []
    assert "Attitude target without a unit quaternion " in open_station.ground.texts[-2] + open_station.ground.texts[-1]


def test_rates_are_set_asked_and_reset(open_station):
    interval = mavlink.MAV_CMD_SET_MESSAGE_INTERVAL
    assert open_station.command(interval, mavlink.MAVLINK_MSG_ID_ATTITUDE, 1e5) == ACCEPTED
    assert open_station.command(mavlink.MAV_CMD_GET_MESSAGE_INTERVAL, mavlink.MAVLINK_MSG_ID_ATTITUDE) == ACCEPTED
    assert open_station.ground.last("MESSAGE_INTERVAL").interval_us == 100000
    assert open_station.command(interval, mavlink.MAVLINK_MSG_ID_ATTITUDE, -1) == ACCEPTED
    open_station.command(mavlink.MAV_CMD_GET_MESSAGE_INTERVAL, mavlink.MAVLINK_MSG_ID_ATTITUDE)
    assert open_station.ground.last("MESSAGE_INTERVAL").interval_us == -1
    assert open_station.command(interval, mavlink.MAVLINK_MSG_ID_ATTITUDE, 0) == ACCEPTED
    open_station.command(mavlink.MAV_CMD_GET_MESSAGE_INTERVAL, mavlink.MAVLINK_MSG_ID_ATTITUDE)
    assert open_station.ground.last("MESSAGE_INTERVAL").interval_us == 20000
    assert open_station.command(interval, mavlink.MAVLINK_MSG_ID_SCALED_IMU, 1e5) == UNSUPPORTED
    assert open_station.command(interval, mavlink.MAVLINK_MSG_ID_ATTITUDE, float("nan")) == DENIED


def test_streams_keep_their_rates_and_make_up_for_nothing(open_station, rng):
    def count(seconds, step):
        before = len(open_station.ground.of("ATTITUDE"))
        for k in range(round(seconds / step)):
            t = start + k * step
            open_station.show(values(rng), t=t)
            open_station.vehicle.stream(open_station.ground.peer, t)
        return len(open_station.ground.of("ATTITUDE")) - before

    start = 0.0
    assert count(2.0, 0.01) == 100
    start = 2.0
    assert count(2.0, 0.1) == 20  # not more often than there is something new
    start = 100.0
    assert count(1.0, 0.02) == 50


def test_a_data_stream_request_changes_this_partner_only(open_station):
    other = Ground()
    open_station.vehicle.greet(other.peer)
    open_station.send(mavlink.MAVLink_request_data_stream_message(1, 1, mavlink.MAV_DATA_STREAM_ALL, 4, 1))
    id_ = mavlink.MAVLINK_MSG_ID_ATTITUDE
    assert open_station.ground.peer.stream.interval(id_) == 0.25
    assert other.peer.stream.interval(id_) == 0.02


def test_there_is_no_mission(station):
    station.send(mavlink.MAVLink_mission_request_list_message(1, 1))
    assert station.ground.last("MISSION_COUNT").count == 0
    station.send(mavlink.MAVLink_mission_count_message(1, 1, 3))
    assert station.ground.last("MISSION_ACK").type == mavlink.MAV_MISSION_UNSUPPORTED
    station.send(mavlink.MAVLink_mission_clear_all_message(1, 1))
    assert station.ground.last("MISSION_ACK").type == mavlink.MAV_MISSION_ACCEPTED


@pytest.mark.parametrize(("opcode", "error"), [(4, 10), (3, 7), (0, 7)])
def test_files_are_refused_at_once(station, opcode, error):
    payload = struct.pack("<HBBBBBBI", 41, 5, opcode, 4, 0, 0, 0, 0) + b"@PARAM/param.pck"
    station.send(mavlink.MAVLink_file_transfer_protocol_message(0, 1, 1, list(payload.ljust(251, b"\0"))))
    answer = bytes(station.ground.last("FILE_TRANSFER_PROTOCOL").payload)
    assert struct.unpack_from("<HBBBBBBIB", answer) == (42, 5, 129, 1, opcode, 0, 0, 0, error)


def test_ping_and_time(station):
    station.send(mavlink.MAVLink_ping_message(77, 5, 0, 0))
    answer = station.ground.last("PING")
    assert (answer.time_usec, answer.seq, answer.target_system) == (77, 5, 255)
    station.send(mavlink.MAVLink_timesync_message(0, 123))
    assert station.ground.last("TIMESYNC").ts1 == 123
    assert station.ground.last("TIMESYNC").tc1 > 0
    n = len(station.ground.heard)
    station.send(mavlink.MAVLink_timesync_message(5, 123))  # an answer is not answered
    assert len(station.ground.heard) == n


def test_what_is_for_another_vehicle_is_left_alone(open_station):
    open_station.send(mavlink.MAVLink_param_request_list_message(2, 1))
    open_station.send(mavlink.MAVLink_param_request_list_message(1, 154))
    assert open_station.ground.of("PARAM_VALUE") == []
    open_station.send(mavlink.MAVLink_param_request_list_message(0, 0))
    assert len(open_station.ground.of("PARAM_VALUE")) == 11


def test_unknown_commands_are_unsupported(open_station):
    assert open_station.command(mavlink.MAV_CMD_NAV_TAKEOFF, 1) == UNSUPPORTED
    assert open_station.command(mavlink.MAV_CMD_REQUEST_MESSAGE, 99999) == UNSUPPORTED
    assert open_station.command(mavlink.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES, 1) == ACCEPTED
    assert open_station.ground.last("AUTOPILOT_VERSION").capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_MAVLINK2


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -1e30, 1e30])
def test_wild_numbers_in_commands_do_no_harm(open_station, value):
    for command in (400, 176, 511, 510, 512, 520, 22):
        for p in ((value,), (1.0, value), (value, value)):
            open_station.command(command, *p)
