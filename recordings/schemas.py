"""Message types of a recording, as ROS 2 message definitions with their dependencies."""

from typing import Literal

from recordings.cdr import parse_schema

_TIME = """\
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""

_HEADER = """\
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
"""

_POINT = """\
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
"""


def _schema(definition: str, *dependencies: str) -> str:
    return f"{'=' * 80}\n".join((definition, *dependencies))


JOINT_STATE = _schema(
    """\
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
""",
    _HEADER,
    _TIME,
)

AMPLIFIER_STATE = _schema(
    """\
# The amplifiers' answers to one SYNC, one entry per joint; header.stamp is the SYNC instant.
std_msgs/Header header
# SYNC counter.
uint32 cycle
# Repetition of the motion; -1 while approaching and stopping.
int32 repeat
# How late the host began the cycle [s].
float64 lateness
# Signed operating voltage [V]; NaN where there is no fresh one.
float64[] voltage
# When each voltage was measured; equals header.stamp where it came with the SYNC.
builtin_interfaces/Time[] voltage_stamp
uint16[] statusword
uint16[] error_code
""",
    _HEADER,
    _TIME,
)

POINT_STAMPED = _schema(
    """\
std_msgs/Header header
geometry_msgs/Point point
""",
    _HEADER,
    _TIME,
    _POINT,
)

CAN_FRAME = _schema(
    """\
std_msgs/Header header
uint32 id
bool is_rtr
bool is_extended
bool is_error
uint8 dlc
uint8[8] data
""",
    _HEADER,
    _TIME,
)

LOG = _schema(
    """\
byte DEBUG=10
byte INFO=20
byte WARN=30
byte ERROR=40
byte FATAL=50
builtin_interfaces/Time stamp
uint8 level
string name
string msg
string file
string function
uint32 line
""",
    _TIME,
)

EXTRA = _schema(
    """\
# Numbers that came with the samples: of another program, named as there; or position_delay_1, voltage_delay_1 ...,
# by how much later than header.stamp each was measured [s]. NaN is a gap.
std_msgs/Header header
string[] name
float64[] value
""",
    _HEADER,
    _TIME,
)

STRING = "string data\n"

_TRANSFORM = """\
MSG: geometry_msgs/TransformStamped
std_msgs/Header header
string child_frame_id
geometry_msgs/Transform transform
"""
_VECTOR_AND_TURN = """\
MSG: geometry_msgs/Transform
geometry_msgs/Vector3 translation
geometry_msgs/Quaternion rotation
"""
_VECTOR = "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
_QUATERNION = "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"


def transforms(definition: str) -> str:
    """Text of a message type that consists of transforms."""
    return _schema(definition, _TRANSFORM, _HEADER, _TIME, _VECTOR_AND_TURN, _VECTOR, _QUATERNION)


TF_MESSAGE = "tf2_msgs/msg/TFMessage", transforms("geometry_msgs/TransformStamped[] transforms\n")
"""Name and text of the message type of /tf and /tf_static."""

DESCRIPTION_TOPICS = {"/robot_description": ("std_msgs/msg/String", STRING), "/tf_static": TF_MESSAGE}
"""Topics of one message each, for programs that draw the robot; of none where nothing says where the axes are."""

TOPICS = {
    "/joint_states": ("sensor_msgs/msg/JointState", JOINT_STATE),
    "/joint_commands": ("sensor_msgs/msg/JointState", JOINT_STATE),
    "/amplifiers": ("delta_msgs/msg/AmplifierState", AMPLIFIER_STATE),
    "/platform_reference": ("geometry_msgs/msg/PointStamped", POINT_STAMPED),
    "/can": ("can_msgs/msg/Frame", CAN_FRAME),
    "/events": ("rcl_interfaces/msg/Log", LOG),
}
"""Name and text of the message type by topic. Every recording has these topics."""

OPTIONAL_TOPICS = {"/extra": ("delta_msgs/msg/NamedValues", EXTRA)}
"""Topics only of imported recordings and of recordings whose drives are read one after the other."""

ALL_TOPICS = TOPICS | DESCRIPTION_TOPICS | OPTIONAL_TOPICS
FIELDS = {topic: parse_schema(text) for topic, (_, text) in (TOPICS | OPTIONAL_TOPICS).items()}
"""Message fields by topic, of what is sampled."""

POSITION_DELAY, VOLTAGE_DELAY, TORQUE_OFFSET = "position_delay", "voltage_delay", "torque_offset"
"""Prefixes of names in /extra, followed by _1 ... _n."""

Level = Literal["debug", "info", "warning", "error", "fatal"]
LEVELS: dict[Level, int] = {"debug": 10, "info": 20, "warning": 30, "error": 40, "fatal": 50}
"""Levels of rcl_interfaces/msg/Log."""

LAYOUT = "1"
"""Version of the file layout, stored in the metadata record `rig`; raise it for changes that break older readers."""
