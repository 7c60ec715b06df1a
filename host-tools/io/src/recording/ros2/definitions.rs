//! Text of the standard messages, field by field as in ROS 2 Humble and later: packages `builtin_interfaces`,
//! `std_msgs`, `geometry_msgs`, `sensor_msgs`, `tf2_msgs` and `visualization_msgs`.

use crate::recording::schema::SEPARATOR;

/// A message type: its name, its fields, and the message types of these fields.
pub(super) struct Definition {
    pub(super) name: &'static str,
    fields: &'static str,
    parts: &'static [Part],
}

/// Name and fields of a message type that another one contains.
type Part = (&'static str, &'static str);

impl Definition {
    /// The schema text (`ros2msg`).
    pub(super) fn text(&self) -> String {
        let mut text = self.fields.to_owned();
        for (name, fields) in self.parts {
            text += &format!("{SEPARATOR}\nMSG: {name}\n{fields}");
        }
        text
    }
}

const HEADER: Part = (
    "std_msgs/Header",
    "builtin_interfaces/Time stamp\nstring frame_id\n",
);
const TIME: Part = ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n");
const DURATION: Part = ("builtin_interfaces/Duration", "int32 sec\nuint32 nanosec\n");
const VECTOR3: Part = ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n");
const POINT: Part = ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n");
const QUATERNION: Part = (
    "geometry_msgs/Quaternion",
    "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n",
);
const POSE: Part = (
    "geometry_msgs/Pose",
    "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
);
const COLOR: Part = (
    "std_msgs/ColorRGBA",
    "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n",
);

pub(super) const WRENCH_STAMPED: Definition = Definition {
    name: "geometry_msgs/msg/WrenchStamped",
    fields: "std_msgs/Header header\ngeometry_msgs/Wrench wrench\n",
    parts: &[
        HEADER,
        TIME,
        (
            "geometry_msgs/Wrench",
            "geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque\n",
        ),
        VECTOR3,
    ],
};

pub(super) const POSE_STAMPED: Definition = Definition {
    name: "geometry_msgs/msg/PoseStamped",
    fields: "std_msgs/Header header\ngeometry_msgs/Pose pose\n",
    parts: &[HEADER, TIME, POSE, POINT, QUATERNION],
};

pub(super) const TWIST_STAMPED: Definition = Definition {
    name: "geometry_msgs/msg/TwistStamped",
    fields: "std_msgs/Header header\ngeometry_msgs/Twist twist\n",
    parts: &[
        HEADER,
        TIME,
        (
            "geometry_msgs/Twist",
            "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n",
        ),
        VECTOR3,
    ],
};

pub(super) const TF_MESSAGE: Definition = Definition {
    name: "tf2_msgs/msg/TFMessage",
    fields: "geometry_msgs/TransformStamped[] transforms\n",
    parts: &[
        (
            "geometry_msgs/TransformStamped",
            "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
        ),
        HEADER,
        TIME,
        (
            "geometry_msgs/Transform",
            "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n",
        ),
        VECTOR3,
        QUATERNION,
    ],
};

pub(super) const MARKER_ARRAY: Definition = Definition {
    name: "visualization_msgs/msg/MarkerArray",
    fields: "visualization_msgs/Marker[] markers\n",
    parts: &[
        ("visualization_msgs/Marker", MARKER),
        HEADER,
        TIME,
        POSE,
        POINT,
        QUATERNION,
        VECTOR3,
        COLOR,
        DURATION,
        (
            "sensor_msgs/CompressedImage",
            "std_msgs/Header header\nstring format\nuint8[] data\n",
        ),
        ("visualization_msgs/UVCoordinate", "float32 u\nfloat32 v\n"),
        (
            "visualization_msgs/MeshFile",
            "string filename\nuint8[] data\n",
        ),
    ],
};

const MARKER: &str = "int32 ARROW=0
int32 CUBE=1
int32 SPHERE=2
int32 CYLINDER=3
int32 LINE_STRIP=4
int32 LINE_LIST=5
int32 CUBE_LIST=6
int32 SPHERE_LIST=7
int32 POINTS=8
int32 TEXT_VIEW_FACING=9
int32 MESH_RESOURCE=10
int32 TRIANGLE_LIST=11
int32 ADD=0
int32 MODIFY=0
int32 DELETE=2
int32 DELETEALL=3
std_msgs/Header header
string ns
int32 id
int32 type
int32 action
geometry_msgs/Pose pose
geometry_msgs/Vector3 scale
std_msgs/ColorRGBA color
builtin_interfaces/Duration lifetime
bool frame_locked
geometry_msgs/Point[] points
std_msgs/ColorRGBA[] colors
string texture_resource
sensor_msgs/CompressedImage texture
visualization_msgs/UVCoordinate[] uv_coordinates
string text
string mesh_resource
visualization_msgs/MeshFile mesh_file
bool mesh_use_embedded_materials
";
